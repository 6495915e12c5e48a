#!/bin/sh
# Pinocchio 4.1.0 (PyPI `pin`) adds the inertia of a joint's rotor (`model.armature`) in rnea, aba, crba, in the kinetic energy and
# in the derivatives. The two regressors of the same quantities leave it out: `computeJointTorqueRegressor` times the dynamic parameters
# misses armature times acceleration, `computeKineticEnergyRegressor` misses half of armature times rate squared. With geared
# motors that is most of the torque, and who identifies masses from measured torques with the regressor finds masses that are too large.
# `model.damping` and the friction limits, read from URDF, are in none of them.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q --disable-pip-version-check pin==4.1.0
cat > "$folder/look.py" <<'PY'
import numpy as np
import pinocchio

model = pinocchio.buildSampleModelManipulator()
model.armature[:] = 0.5
data = model.createData()
draw = np.random.default_rng(0)
q = 0.3 * draw.standard_normal(model.nq)
v, a = draw.standard_normal(model.nv), draw.standard_normal(model.nv)
known = np.concatenate([inertia.toDynamicParameters() for inertia in list(model.inertias)[1:]])

torque = pinocchio.rnea(model, data, q, v, a)
regressed = pinocchio.computeJointTorqueRegressor(model, data, q, v, a) @ known
print("torque that the regressor misses, per rad/s2:", np.round((torque - regressed) / a, 9))
assert np.allclose(torque - regressed, model.armature * a), "the regressor holds the rotor now"
mass = np.triu(pinocchio.crba(model, data, q))
mass = mass + np.triu(mass, 1).T
energy = pinocchio.computeKineticEnergy(model, data, q, v)
assert np.isclose(energy, 0.5 * v @ mass @ v), "the energy holds no rotor"
missed = energy - float(pinocchio.computeKineticEnergyRegressor(model, data, q, v) @ known)
print("energy", round(float(energy), 6), "J, of which the regressor misses", round(float(missed), 6), "J")
assert np.isclose(missed, 0.5 * np.sum(model.armature * v**2)), "the regressor of energy holds the rotor now"

model.damping[:] = 5.0
assert np.allclose(pinocchio.rnea(model, data, q, v, a), torque), "damping counts in rnea now"
assert np.allclose(pinocchio.aba(model, data, q, v, torque), a), "damping counts in aba now"
print("damping of 5 N m s changes neither rnea nor aba")
PY
"$folder/venv/bin/python" "$folder/look.py"
