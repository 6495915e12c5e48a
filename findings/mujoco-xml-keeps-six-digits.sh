#!/bin/sh
# MuJoCo 4.0.0: what `MjSpec.to_xml` writes is not the model that it was written from. Every number is rounded to six
# significant digits, whatever it is: a body at 1234.56789 m comes back at 1234.57 m, 2 mm off, key frames, limits and half sizes too,
# each by up to five parts in a million. `to_xml` has no option for more.
# Who edits a model and keeps it as text loses digits at every round; keep the MjSpec, or the compiled model in its binary form,
# which has all of them.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q --disable-pip-version-check mujoco==4.0.0
cat > "$folder/look.py" <<'PY'
import sys

import mujoco

TEXT = """<mujoco><worldbody><body pos="1234.56789 0.123456789 0"><joint range="-12.3456789 1"/>
<geom type="box" size="0.123456789 0.2 0.3"/></body></worldbody><keyframe><key qpos="0.123456789"/></keyframe></mujoco>"""
model = mujoco.MjSpec.from_string(TEXT).compile()
again = mujoco.MjModel.from_xml_string(mujoco.MjSpec.from_string(TEXT).to_xml())
place = float(again.body_pos[1, 0])
print("a body at", float(model.body_pos[1, 0]), "m is written back at", place, "m")
print("a key frame of", float(model.key_qpos[0, 0]), "rad at", float(again.key_qpos[0, 0]), "rad")
assert place == 1234.57 and float(again.key_qpos[0, 0]) == 0.123457, "numbers are written otherwise"
mujoco.mj_saveModel(model, f"{sys.argv[1]}/model.mjb")
binary = mujoco.MjModel.from_binary_path(f"{sys.argv[1]}/model.mjb")
assert (binary.body_pos == model.body_pos).all() and (binary.key_qpos == model.key_qpos).all()
print("the binary form keeps both")
PY
"$folder/venv/bin/python" "$folder/look.py" "$folder"
