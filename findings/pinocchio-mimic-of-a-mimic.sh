#!/bin/sh
# URDF lets a joint mimic one that mimics another (fingers in three parts are described so). Pinocchio 4.1.0 (PyPI `pin`):
# - without `mimic=True` all three joints are free and nothing is said: nq is 3 where the robot has one degree of freedom;
# - with `mimic=True` the model cannot be built: a ValueError about "configuration spaces" that names neither joint nor file.
# MuJoCo 4.0.0 reads the file with two joint equalities, each to its direct leader, offsets and multipliers as written.
# Who wants one degree of freedom composes the couplings first: q3 = k3 (k2 q1 + b2) + b3.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q --disable-pip-version-check pin==4.1.0 mujoco==4.0.0
cat > "$folder/look.py" <<'PY'
import mujoco
import numpy as np
import pinocchio

INERTIAL = '<inertial><mass value="1"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>'


def joint(name, parent, child, mimic=""):
    return (f'<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/><axis xyz="0 0 1"/>'
            f'<limit lower="-2" upper="2" effort="7" velocity="3"/>{mimic}</joint>')


FINGER = ('<robot name="finger"><link name="palm"/>' + "".join(f'<link name="{n}">{INERTIAL}</link>' for n in "abc")
          + joint("j1", "palm", "a")
          + joint("j2", "a", "b", '<mimic joint="j1" multiplier="-1.5" offset="0.2"/>')
          + joint("j3", "b", "c", '<mimic joint="j2" multiplier="2" offset="0.1"/>') + "</robot>")

plain = pinocchio.buildModelFromXML(FINGER)
print("Pinocchio by default: nq =", plain.nq)
assert plain.nq == 3
try:
    pinocchio.buildModelFromXML(FINGER, mimic=True)
except ValueError as error:
    message = str(error)
else:
    raise AssertionError("a chain of mimic joints is read now")
print("Pinocchio with mimic=True:", message.split("hint:")[1].strip())
assert "j2" not in message and "j3" not in message

model = mujoco.MjModel.from_xml_string(FINGER)
print("MuJoCo: joint equalities", model.eq_obj1id.tolist(), "to", model.eq_obj2id.tolist(), model.eq_data[:, :2].tolist())
assert model.neq == 2 and np.allclose(model.eq_data[:, :2], [[0.2, -1.5], [0.1, 2.0]])
assert model.eq_obj1id.tolist() == [1, 2] and model.eq_obj2id.tolist() == [0, 1]
PY
"$folder/venv/bin/python" "$folder/look.py"
