#!/bin/sh
# Two attributes of MJCF that Pinocchio 4.1.0 (PyPI `pin`, buildModelFromMJCF) reads otherwise than MuJoCo 4.0.0, silently:
# - <compiler eulerseq="XYZ"/>: capitals mean rotations about the fixed axes of the parent, small letters about axes that turn
#   along. Pinocchio takes capitals for something else than either: a body with euler="10 20 30" differs by 12 degrees from
#   MuJoCo's; with "xyz" (the default) and "zyx" both agree.
# - limited="false" beside a range: MuJoCo does not limit the joint, Pinocchio takes the range as limits.
# For users of tamplang: angles in MJCF are to be read by MuJoCo.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q --disable-pip-version-check pin==4.1.0 mujoco==4.0.0
cat > "$folder/look.py" <<'PY'
import os
import tempfile

import mujoco
import numpy as np
import pinocchio


def read(text):
    path = os.path.join(tempfile.mkdtemp(), "arm.xml")
    with open(path, "w") as file:
        file.write(text)
    return mujoco.MjModel.from_xml_string(text), pinocchio.buildModelFromMJCF(path)


def arm(compiler, joint="", body=""):
    return (f'<mujoco>{compiler}<worldbody><body name="arm" {body}><joint name="j" axis="0 1 0" {joint}/>'
            '<geom type="capsule" size="0.05 0.2"/></body></worldbody></mujoco>')


for sequence in ("xyz", "zyx", "XYZ", "ZYX"):
    engine, model = read(arm(f'<compiler eulerseq="{sequence}"/>', body='euler="10 20 30"'))
    state, data = mujoco.MjData(engine), model.createData()
    mujoco.mj_forward(engine, state)
    pinocchio.framesForwardKinematics(model, data, np.zeros(1))
    between = state.body("arm").xmat.reshape(3, 3).T @ data.oMf[model.getFrameId("arm")].rotation
    degrees = np.degrees(np.arccos(np.clip((np.trace(between) - 1) / 2, -1, 1)))
    print(f"eulerseq {sequence}: {degrees:.2f} degrees between MuJoCo and Pinocchio")
    assert (degrees < 1e-5) == sequence.islower()
engine, model = read(arm('<compiler angle="radian"/>', joint='range="-1 1" limited="false"'))
print("limited=false: MuJoCo limited", bool(engine.jnt_limited[0]), "; Pinocchio", model.lowerPositionLimit, model.upperPositionLimit)
assert not engine.jnt_limited[0] and model.upperPositionLimit[0] == 1
PY
"$folder/venv/bin/python" "$folder/look.py"
