#!/bin/sh
# CPython 3.11.7 (what the version in use does is printed first).
# A KeyboardInterrupt that is raised while code runs which was compiled from a string by exec() (collections.namedtuple
# and dataclasses do so when a module is imported) is remembered by the interpreter even where a program catches it.
# A program started as `python -m NAME` then ends by SIGINT, whatever status it gives to sys.exit, so that a shell or a
# caller sees -2 instead of 130 or 0. The same program started as `python FILE` ends with its own status, and so does
# `python -m` when any other string is executed afterwards, which forgets the interrupt.
# Source: run_eval_code_obj (Python/pythonrun.c) sets unhandled_keyboard_interrupt, Py_RunMain (Modules/main.c) reads it,
# and only a file's SystemExit leaves the process before that.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 --version
cat > "$folder/caught.py" <<'PROGRAM'
import signal
import sys

signal.signal(signal.SIGINT, signal.default_int_handler)
try:
    exec("signal.raise_signal(signal.SIGINT)")
except KeyboardInterrupt:
    pass
if sys.argv[1] == "forget":
    exec("")
sys.exit(7)
PROGRAM
cd "$folder"
python3 - <<'CHECK'
import subprocess
import sys

status = {
    way: subprocess.run([sys.executable, *way.split()]).returncode
    for way in ("caught.py keep", "-m caught keep", "-m caught forget")
}
print(status)
assert status == {"caught.py keep": 7, "-m caught keep": -2, "-m caught forget": 7}
CHECK
