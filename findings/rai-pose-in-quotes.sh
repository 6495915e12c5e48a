#!/bin/sh
# A pose in rai's .g files is the attribute Q: as an array of 3 numbers (a place), 4 (a turn, scalar first) or 7 (both), or
# as words in quotes, such as "t(0.1 0.2 0.3) d(90 1 0 0)". One expects numbers in quotes to be words of that kind, or to be
# refused, or read like the array. robotic 0.4.2 (the rai of PyPI) reads seven numbers in quotes, with brackets and commas or
# bare, as the pose of the array, but refuses three in either form ("could not read Transformation struct"), and four too.
# For users of tamplang: `tamplang import` reads and refuses these as rai does.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q --disable-pip-version-check robotic==0.4.2
cat > "$folder/look.py" <<'PY'
import os
import sys
import tempfile

import robotic


def pose(text):
    path = os.path.join(tempfile.mkdtemp(), "scene.g")
    with open(path, "w") as file:
        file.write("world: {}\nbox(world): { Q: %s, shape: box, size: [.1, .1, .1] }\n" % text)
    scene = robotic.Config()
    try:
        scene.addFile(path)
    except RuntimeError as error:
        return "refused" if "could not read Transformation" in str(error) else str(error)
    frame = scene.getFrame("box")
    return [round(float(v), 3) for v in (*frame.getPosition(), *frame.getQuaternion())]


place, both = [0.1, 0.2, 0.3, 1.0, 0.0, 0.0, 0.0], [0.1, 0.2, 0.3, 0.0, 1.0, 0.0, 0.0]
expected = {
    "[.1, .2, .3]": place, "[0, 1, 0, 0]": [0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0], "[.1, .2, .3, 0, 1, 0, 0]": both,
    '"t(.1 .2 .3)"': place, '"[.1, .2, .3, 0, 1, 0, 0]"': both, '".1 .2 .3 0 1 0 0"': both,
    '"[.1, .2, .3]"': "refused", '".1 .2 .3"': "refused", '"[0, 1, 0, 0]"': "refused", '"0 1 0 0"': "refused",
}
for text, wanted in expected.items():
    found = pose(text)
    print(text, "->", found, file=sys.stderr)
    assert found == wanted, (text, found)
PY
"$folder/venv/bin/python" "$folder/look.py" > "$folder/log"  # where rai tells how it came to refuse
