"""Which tool's file a file is, and how it gets into a program: by what it holds, else by its ending."""

from __future__ import annotations

import os
import re
import stat
from pathlib import PurePath

from ...langs.diagnostics import Diagnostic
from ...langs.frozen import dataclass
from ..xml_marks import COMMENT, INSTRUCTION, replaced

HEAD = 64_000
"""Bytes that are looked at: comments may stand before what tells the kind."""
_PDDL = re.compile(r"\(\s*define\s*\(\s*(domain|problem)\b", re.IGNORECASE)
_CATALOGUE = re.compile(r'"(modules|joints|bodies|obstacles)"\s*:')
_COMMENT = re.compile(r";[^\n]*")


@dataclass(frozen=True, slots=True)
class FileKind:
    """`name` as users know it; `help` says what to do with FILE, whose plain name is NAME."""

    key: str
    name: str
    help: str


_MODELS = "tamplang import FILE -o NAME.tamp makes a program of it"
KINDS = {
    kind.key: kind
    for kind in (
        FileKind("domain", "PDDL domain", "tamplang import FILE PROBLEM.pddl -o task.tamp makes a program of both"),
        FileKind("problem", "PDDL problem", "tamplang import DOMAIN.pddl FILE -o task.tamp makes a program of both"),
        FileKind("urdf", "URDF", 'a program takes it in: module arm from urdf "FILE" { effector A: "LINK" }'),
        FileKind("xacro", "xacro file", "a URDF is made of it by `xacro FILE > NAME.urdf`"),
        FileKind("mjcf", "MuJoCo model (MJCF)", _MODELS),
        FileKind("sdf", "SDF", _MODELS),
        FileKind("rai", "rai scene", _MODELS),
        FileKind("rules", "file of rai rules", "tamplang import FILE SCENE.g -o NAME.tamp makes a program of both"),
        FileKind("modules", "catalogue of modules or scene of CoBRA (JSON)", _MODELS),
        FileKind("mesh", "mesh", 'a program takes it in as a body: object b: hull("FILE", 1 m) at (0, 0, 0)'),
    )
}
_ROOTS = {"robot": "urdf", "mujoco": "mjcf", "mujocoinclude": "mjcf", "sdf": "sdf", "gazebo": "sdf", "COLLADA": "mesh"}
_ENDINGS = {
    ".pddl": "problem", ".urdf": "urdf", ".xacro": "xacro", ".sdf": "sdf", ".mjcf": "mjcf", ".g": "rai",
    ".fol": "rules", ".stl": "mesh", ".obj": "mesh", ".dae": "mesh",
}  # fmt: skip


def kind_of(path: str) -> FileKind | None:
    """The kind of a file of others; None where it is none, or cannot be read."""
    try:
        if not stat.S_ISREG(os.stat(path).st_mode):
            return None
        with open(path, "rb", opener=lambda name, flags: os.open(name, flags | os.O_NONBLOCK)) as stream:
            head = stream.read(HEAD)
    except (OSError, ValueError):
        return None
    return kind_of_text(path, head.decode("utf-8-sig", errors="replace"))


def kind_of_text(path: str, head: str) -> FileKind | None:
    """The kind of a file that begins with `head`."""
    ending = PurePath(path).suffix.lower()
    if ending == ".tamp":
        return None
    text = replaced(head, (COMMENT, INSTRUCTION), lambda _: "").lstrip()
    if match := re.match(r"<([\w:.-]+)", text):
        key = _ROOTS.get(match[1])
        if key == "urdf" and (ending == ".xacro" or "<xacro:" in text):
            key = "xacro"
        return KINDS.get(key or _ENDINGS.get(ending, ""))
    if match := _PDDL.match(_COMMENT.sub("", head).lstrip()):
        return KINDS[match[1].lower()]
    if text.startswith(("{", "[")) and _CATALOGUE.search(text) and '"tracks"' not in text:
        return KINDS["modules"]
    return KINDS.get(_ENDINGS.get(ending, ""))


def foreign(path: str) -> Diagnostic | None:
    """What to say where a program is expected and `path` is a file of others."""
    kind = kind_of(path)
    if kind is None:
        return None
    plain = PurePath(path).name.split(".")[0]
    help = kind.help.replace("FILE", path).replace("NAME", plain)
    return Diagnostic("E0021", f"`{path}` is a {kind.name}, not a program", help=help)
