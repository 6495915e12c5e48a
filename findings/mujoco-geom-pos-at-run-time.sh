#!/bin/sh
# MuJoCo 4.0.0: writing model.geom_pos at run time moves a geom only if it was not compiled at the origin of its body. The
# compiler keeps in model.geom_sameframe that such a geom shares the body's frame, and mj_forward then copies the body's pose
# and never reads geom_pos: the geom stays where it was, without a word, and contacts that were meant to be are missing. The
# same model with the geom a centimetre aside follows. With geom_sameframe set to 0 for that geom, the first follows too.
# For users of tamplang: `tamplang simulate --contact` places the pads of feet that way, and sets that field.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q --disable-pip-version-check mujoco==4.0.0 numpy==2.4.6
cat > "$folder/look.py" <<'PY'
import mujoco

heights = []
for place in ("", 'pos="0.01 0 0"'):
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><worldbody><body pos="0 0 1"><freejoint/><geom type="sphere" size="0.1" {place}/></body></worldbody></mujoco>')
    state = mujoco.MjData(model)
    model.geom_pos[0] = [0.0, 0.0, 0.5]
    mujoco.mj_forward(model, state)
    heights.append(float(state.geom_xpos[0][2]))
    model.geom_sameframe[0] = 0
    mujoco.mj_forward(model, state)
    heights.append(float(state.geom_xpos[0][2]))
print("height of the geom, asked for 1.5 m: at the origin {}, then with geom_sameframe 0 {}; aside {}, {}".format(*heights))
assert heights == [1.0, 1.5, 1.5, 1.5]
PY
"$folder/venv/bin/python" "$folder/look.py"
