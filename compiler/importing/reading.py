"""Files of others as programs: from paths to text."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

from ...langs.diagnostics import Diagnostic, SourceError
from ...langs.formatter import format_made
from ...langs.frozen import dataclass
from ...langs.reader import read_bytes
from ...langs.source import Source, Span
from .faults import MOST_FAULTS
from .kinds import KINDS, FileKind, kind_of_text
from .model_texts import program, urdf
from .models import Models
from .names import plain_name
from .nodes import Faults
from .sunken_roots import cut_roots

PDDL = frozenset(("domain", "problem"))
MODELS = frozenset(("mjcf", "sdf", "modules", "rai"))
"""Kinds that hold robots and bodies."""
RULES = "rules"
LONGEST_NAME = 80
"""Letters of a robot in the name of a file: disks take 255 bytes."""
NUMBER = re.compile(r"(?<![\w.])[0-9]+\.?[0-9]*(?:[eE][+-]?[0-9]+)?")
LONGEST_NUMBER = 400
"""Digits of a number that is looked at: the largest one has 309."""
MOST = 1e308
LIKE = 4.0
"""Powers of ten between a number in a file and what became of it: sums and turns change it by less than one, and the
millimetres of a mesh by three."""
IMPORTED = PDDL | MODELS | {RULES}
"""Kinds that programs are made of."""


@dataclass(frozen=True, slots=True)
class Imported:
    """The text of a program, the files that go beside it, by name, and what has no counterpart."""

    text: str
    beside: dict[str, str]
    told: tuple[Diagnostic, ...] = ()


def import_files(paths: Sequence[str], stem: str = "imported") -> Imported:
    """The program of a PDDL domain and problem, or of the models of one file. What goes beside the program is called
    `stem` and what it is. Raises SourceError with all faults."""
    found = [_source(path) for path in paths]
    if {kind.key for _, kind in found} <= PDDL:
        from .pddl import import_pddl

        return Imported(format_made(import_pddl([source for source, _ in found]).text), {})
    kinds = [kind.key for _, kind in found]
    if kinds.count(RULES) == 1 and kinds.count("rai") == len(kinds) - 1 <= 1:
        return _rules(found, stem)
    if len(found) > 1:
        raise _refusal("E0021", "these are not one program: only a domain and a problem of PDDL go together, or rules "
                       "and a scene of rai", "import each file by itself")  # fmt: skip
    source, kind = found[0]
    if kind.key not in MODELS:
        help = kind.help.replace("FILE", paths[0])
        raise _refusal("E0021", f"`{paths[0]}` is a {kind.name}, which is not imported", help)
    return _imported(_models(source, kind.key), stem, source)


def _rules(found: Sequence[tuple[Source, FileKind]], stem: str) -> Imported:
    """The rules of one file, and the scene of another where there is one."""
    from .rai_rules import import_rules
    from .rai_texts import read_scene

    scene = next((read_scene(source).frames for source, kind in found if kind.key == "rai"), None)
    rules = next(source for source, kind in found if kind.key == RULES)
    made = import_rules(rules, stem, scene)
    return Imported(format_made(made.text), {}, tuple(made.faults.told))


def _models(source: Source, key: str) -> Models:
    if key == "sdf":
        from .sdf import import_sdf

        return import_sdf(source)
    if key == "modules":
        from .catalogues import import_catalogue

        return import_catalogue(source)
    if key == "rai":
        from .rai_texts import import_rai

        return import_rai(source)
    from .mjcf import import_mjcf

    return import_mjcf(source)


def _imported(models: Models, stem: str, source: Source) -> Imported:
    if not models.robots and not models.things and not models.declarations:
        nothing = Diagnostic("E0020", f"`{source.path}` holds no robot and no body that others may hit")
        raise SourceError([nothing, *models.told[:MOST_FAULTS]])
    start = Span(source.path, 0, 0, 1, 1, 1, 1)
    models.told += [Diagnostic("W0019", message, start) for message in cut_roots(models)]
    names = {robot.name: _file_name(stem, robot.name, k) for k, robot in enumerate(models.robots, 1)}
    try:
        texts = {names[robot.name]: urdf(robot) for robot in models.robots}
        text = format_made(program(models, names, plain_name(stem)))
    except OverflowError as error:
        message = f"`{source.path}` puts something at {error}: that is no place in a scene"
        raise SourceError([Diagnostic("E0022", message, _near(source, str(error)))]) from None
    return Imported(text, texts, tuple(models.told))


def _near(source: Source, told: str) -> Span | None:
    """The number of the file that is most like the one told: that was worked out of several."""
    value = min(abs(float(told.split()[0])), MOST)
    numbers = [(abs(float(m[0])), m) for m in NUMBER.finditer(source.text) if len(m[0]) <= LONGEST_NUMBER]
    powers = [(abs(math.log10(min(number, MOST)) - math.log10(value)), m) for number, m in numbers if number > 0.0]
    power, match = min(powers, key=lambda one: one[0], default=(math.inf, None))
    return None if match is None or not power <= LIKE else Faults(source).span(match.start(), match.end())


def _file_name(stem: str, robot: str, number: int) -> str:
    """The file beside the program, called like its robot where a disk takes that."""
    return f"{stem}_{robot if len(robot) <= LONGEST_NAME else f'{robot[:LONGEST_NAME]}_{number}'}.urdf"


def _source(path: str) -> tuple[Source, FileKind]:
    """The text and kind of a file. Bytes that are not UTF-8 are taken as Latin-1: they stand in comments."""
    content = read_bytes(path)
    if not content.strip():
        raise _refusal("E0013", f"`{path}` is empty")
    if b"\0" in content:
        raise _refusal("E0014", f"`{path}` is not a text file")
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = content.decode("latin-1")
    kind = kind_of_text(path, text)
    if kind is None:
        known = ", ".join(k.name for k in KINDS.values() if k.key in IMPORTED)
        raise _refusal("E0021", f"`{path}` is nothing that can be imported", f"what can: {known}")
    return Source(path, text.replace("\r\n", "\n").replace("\r", "\n")), kind


def _refusal(code: str, message: str, help: str | None = None) -> SourceError:
    return SourceError([Diagnostic(code, message, help=help)])
