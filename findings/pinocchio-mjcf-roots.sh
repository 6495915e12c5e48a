#!/bin/sh
# Three things about the bodies that lie directly in the <worldbody> of an MJCF file, as Pinocchio 4.1.0 (PyPI `pin`) reads
# them with buildModelFromMJCF, each without a word, beside MuJoCo 4.0.0:
# - only the first such body is read: the second robot of a scene is missing;
# - of one without a joint (a table, a robot's base) the pose is lost: it and all that stands on it come to lie at the origin;
# - of one with a free joint and a rotation, the start that MuJoCo stores (qpos0, kept by Pinocchio as a reference
#   configuration) puts the body elsewhere: the joint gets a placement besides. Without a rotation it does not.
# For users of tamplang: let MuJoCo read MJCF, and compare body poses before trusting another reader.
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

GEOM = '<geom type="capsule" size="0.05 0.2"/>'


def places(bodies, names):
    """Positions (m) of bodies in the world at the model's own start: by MuJoCo, by Pinocchio."""
    text = f"<mujoco><worldbody>{bodies}</worldbody></mujoco>"
    path = os.path.join(tempfile.mkdtemp(), "scene.xml")
    with open(path, "w") as file:
        file.write(text)
    engine, model = mujoco.MjModel.from_xml_string(text), pinocchio.buildModelFromMJCF(path)
    state, data = mujoco.MjData(engine), model.createData()
    mujoco.mj_forward(engine, state)
    start = model.referenceConfigurations["qpos0"]
    pinocchio.framesForwardKinematics(model, data, start)
    for name in names:
        there = data.oMf[model.getFrameId(name)].translation if model.existFrame(name) else None
        print(f"  {name}: MuJoCo {state.body(name).xpos.tolist()}, Pinocchio {there if there is None else there.tolist()}")
        yield state.body(name).xpos, there


arm = f'<body name="arm" pos="0.5 0 0"><joint name="j" axis="0 1 0"/>{GEOM}</body>'
print("two roots:")
seen = list(places(f'<body name="first"><joint name="f" axis="0 1 0"/>{GEOM}</body>{arm}', ("first", "arm")))
assert seen[0][1] is not None and seen[1][1] is None
print("a root without a joint, 1 2 3 away:")
seen = list(places(f'<body name="base" pos="1 2 3"><geom type="sphere" size="0.1"/>{arm}</body>', ("base", "arm")))
assert np.allclose(seen[0][0], [1, 2, 3]) and np.allclose(seen[0][1], 0)
assert np.allclose(seen[1][0] - seen[1][1], [1, 2, 3])
for turn, agrees in (("0 0 0", True), ("0 0 90", False)):
    print(f"a free body, turned by {turn}:")
    seen = list(places(f'<body name="free" pos="1 2 3" euler="{turn}"><freejoint name="f"/>{GEOM}</body>', ("free",)))
    assert np.allclose(*seen[0]) == agrees
PY
"$folder/venv/bin/python" "$folder/look.py"
