#!/bin/sh
# PDDL lets a parameter have one of several types: ?x - (either car truck). The package `pddl` 0.5.1 reads that, keeps it in
# predicates when it writes a domain back (domain_to_string), but drops the word in the parameters of actions: they come out as
# `?x - car truck` (in any order), which is no PDDL: its own parser refuses it.
# For users of tamplang: the domains that it writes give each parameter one type, so nothing is lost there.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q --disable-pip-version-check pddl==0.5.1
cat > "$folder/look.py" <<'PY'
import os
import tempfile

from pddl import parse_domain
from pddl.formatter import domain_to_string

path = os.path.join(tempfile.mkdtemp(), "domain.pddl")


def read(text):
    with open(path, "w") as file:
        file.write(text)
    return parse_domain(path)


written = domain_to_string(read("""(define (domain road) (:requirements :strips :typing) (:types car truck - object)
    (:predicates (parked ?x - (either car truck)))
    (:action leave :parameters (?x - (either car truck)) :precondition (parked ?x) :effect (not (parked ?x))))"""))
print(written)
predicates, _, action = written.partition("(:action")
assert "(either " in predicates and "(either " not in action
try:
    read(written)
except Exception as error:
    print("its own parser:", type(error).__name__)
else:
    raise AssertionError("what is written is read back now")
PY
"$folder/venv/bin/python" "$folder/look.py"
