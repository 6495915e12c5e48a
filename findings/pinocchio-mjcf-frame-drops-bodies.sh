#!/bin/sh
# MJCF lets a <frame> stand around bodies, to move them together (MuJoCo since 3.1, and what its own converters write).
# Pinocchio 4.1.0 (PyPI `pin`), buildModelFromMJCF: a body inside a <frame> is not read, nor is anything below it. Nothing is
# said: the arm below has two joints in MuJoCo 4.0.0 and one in Pinocchio, and its mass is half.
# Written without the frame, its pose moved into the body, both agree.
# For users of tamplang: let MuJoCo read MJCF; never Pinocchio alone.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q --disable-pip-version-check pin==4.1.0 mujoco==4.0.0
cat > "$folder/look.py" <<'PY'
import os
import tempfile

import mujoco
import pinocchio

GEOM = '<geom type="capsule" size="0.05 0.2"/>'
LOWER = f'<body name="lower" pos="0 0 0.4"><joint name="elbow" axis="0 1 0"/>{GEOM}</body>'


def read(inner):
    text = (f'<mujoco><worldbody><body name="upper"><joint name="shoulder" axis="0 1 0"/>{GEOM}{inner}</body>'
            "</worldbody></mujoco>")
    path = os.path.join(tempfile.mkdtemp(), "arm.xml")
    with open(path, "w") as file:
        file.write(text)
    return mujoco.MjModel.from_xml_string(text), pinocchio.buildModelFromMJCF(path)


for name, inner in (("plain", LOWER), ("in a frame", f'<frame pos="0.1 0 0">{LOWER}</frame>')):
    engine, model = read(inner)
    masses = sum(engine.body_mass), sum(inertia.mass for inertia in model.inertias)
    print(f"{name}: MuJoCo nv {engine.nv}, {masses[0]:.2f} kg; Pinocchio nv {model.nv}, {masses[1]:.2f} kg")
    assert engine.nv == 2 and model.nv == (2 if name == "plain" else 1)
    assert abs(masses[1] - masses[0] * model.nv / 2) < 1e-9
PY
"$folder/venv/bin/python" "$folder/look.py"
