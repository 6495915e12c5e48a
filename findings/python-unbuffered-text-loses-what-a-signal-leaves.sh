#!/bin/sh
# CPython 3.11.7 (what the version in use does is printed first).
# With `python -u` or PYTHONUNBUFFERED=1, as containers often set it, sys.stdout is text upon a raw file without a
# buffer. A raw write to a pipe may take only a part, which it does where a signal with a handler arrives while it waits
# for a slow reader. The text layer does not look at how much was taken: the rest is lost, no error is raised, and the
# program ends with 0. With a buffer all arrives, as the buffer writes again until nothing is left.
# Source: _textiowrapper_writeflush (Modules/_io/textio.c) drops what the write of its buffer returns;
# _io_FileIO_write (Modules/_io/fileio.c) returns the count of a partial write.
set -eu
unset PYTHONUNBUFFERED
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 --version
cat > "$folder/long.py" <<'PROGRAM'
import signal
import sys

signal.signal(signal.SIGALRM, lambda *_: None)
signal.setitimer(signal.ITIMER_REAL, 0.02, 0.02)
sys.stdout.write("x" * 5_000_000)
PROGRAM
cd "$folder"
python3 - <<'CHECK'
import subprocess
import sys
import time

arrived = {}
for way in ("", "-u"):
    asked = [sys.executable, *way.split(), "long.py"]
    with subprocess.Popen(asked, stdout=subprocess.PIPE) as program:
        time.sleep(0.5)
        arrived[way or "with a buffer"] = len(program.stdout.read()), program.wait()
print(arrived)
assert arrived["with a buffer"] == (5_000_000, 0)
assert arrived["-u"][0] < 5_000_000 and arrived["-u"][1] == 0
CHECK
