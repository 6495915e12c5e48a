#!/bin/sh
# A planar joint of a URDF names in <axis> the normal of its plane. Pinocchio 4.1.0 (PyPI `pin`) accepts any axis and always
# builds a joint that moves in the x-y plane and turns about z of the joint frame; no warning. MuJoCo 4.0.0 reads the same file
# with two slides across the axis and a hinge about it. So one file is two robots, and no reader complains.
# Who reads URDFs with Pinocchio turns the joint frame so that z is the normal before, as the URDF specification means it.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q --disable-pip-version-check pin==4.1.0 mujoco==4.0.0
cat > "$folder/look.py" <<'PY'
import mujoco
import numpy as np
import pinocchio

INERTIAL = ('<inertial><mass value="1"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>')
ROBOT = f"""<robot name="cart"><link name="floor"/><link name="cart">{INERTIAL}</link>
<joint name="drive" type="planar"><parent link="floor"/><child link="cart"/><axis xyz="1 0 0"/></joint></robot>"""

model = pinocchio.buildModelFromXML(ROBOT)
data = model.createData()
pinocchio.forwardKinematics(model, data, np.array([0.3, 0.4, 1.0, 0.0]))
place = data.oMi[1].translation
print("Pinocchio: coordinates (0.3, 0.4) with the normal along x put the cart at", place)
assert np.allclose(place, [0.3, 0.4, 0.0]), "the normal is no longer dropped"

other = mujoco.MjModel.from_xml_string(ROBOT)
slides = other.jnt_axis[other.jnt_type == mujoco.mjtJoint.mjJNT_SLIDE]
hinge = other.jnt_axis[other.jnt_type == mujoco.mjtJoint.mjJNT_HINGE]
print("MuJoCo: slides along", np.round(slides, 6).tolist(), "and a hinge about", np.round(hinge, 6).tolist())
assert np.allclose(slides[:, 0], 0.0, atol=1e-9) and np.allclose(np.abs(hinge), [[1, 0, 0]]), "MuJoCo reads it otherwise"
PY
"$folder/venv/bin/python" "$folder/look.py"
