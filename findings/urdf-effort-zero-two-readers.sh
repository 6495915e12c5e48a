#!/bin/sh
# `effort="0"` in the <limit> of a URDF joint stands in many public files for "not stated". Readers differ without a word:
# MuJoCo 4.0.0 takes any other number as a hard limit of the joint's actuator force (`jnt_actfrcrange`; its documentation of URDF import
# does not lead one to expect it), and 0 as no limit at all; Pinocchio 4.1.0 (PyPI `pin`)
# keeps 0 as a limit of 0 N m. And a `continuous` joint that states lower and upper is unlimited to both.
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


def joint(name, kind, parent, child, effort):
    return (f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/><axis xyz="0 0 1"/>'
            f'<limit lower="-0.5" upper="0.5" effort="{effort}" velocity="3"/></joint>')


ARM = ('<robot name="arm"><link name="base"/>' + "".join(f'<link name="{n}">{INERTIAL}</link>' for n in "abc")
       + joint("j1", "revolute", "base", "a", 7) + joint("j2", "revolute", "a", "b", 0)
       + joint("j3", "continuous", "b", "c", 4) + "</robot>")

model = mujoco.MjModel.from_xml_string(ARM)
print("MuJoCo: limited", model.jnt_actfrclimited.tolist(), "range", model.jnt_actfrcrange.tolist(),
      "position limited", model.jnt_limited.tolist())
assert model.jnt_actfrclimited.tolist() == [True, False, True]
assert np.allclose(model.jnt_actfrcrange, [[-7, 7], [0, 0], [-4, 4]])
assert model.jnt_limited.tolist() == [True, True, False]

peer = pinocchio.buildModelFromXML(ARM)
print("Pinocchio: effort", peer.upperEffortLimit.tolist(), "nq", peer.nq, "upper", peer.upperPositionLimit.tolist())
assert peer.upperEffortLimit.tolist() == [7.0, 0.0, 4.0]
assert peer.nq == 4 and (peer.upperPositionLimit[2:] > 1.0).all(), "the limits of a continuous joint are read now"
PY
"$folder/venv/bin/python" "$folder/look.py"
