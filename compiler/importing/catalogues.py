"""Catalogues of modules and scenes as timor and CoBRA write them: JSON in which `Infinity` may stand bare.

A module is bodies and joints, of which each turns about, or slides along, the z-axis of its own frame; connectors have
a gender, a size and a kind, and point outward along z.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping, Sequence
from typing import Any

from ...langs.diagnostics import Diagnostic, SourceError
from ...langs.source import Source, Span
from ..foreign import Files, beside
from ..ir import IDENTITY, Pose
from ..named_meshes import UnreadMesh
from ..poses import compose, make
from .mesh_forms import MeshReader
from .models import FAR, Form, Hinge, Models, PartWeight, RobotEnd, RobotModel, RobotPart, Thing, linked
from .names import STANDARD, GivenNames
from .nodes import Faults

GENDERS = {"m": "male", "male": "male", "f": "female", "female": "female", "h": "hermaphrodite", "": "hermaphrodite",
           "hermaphroditic": "hermaphrodite"}  # fmt: skip
KINDS = {"revolute": "revolute", "continuous": "revolute", "revolute_active": "revolute",
         "prismatic": "prismatic", "prismatic_active": "prismatic", "fixed": "fixed"}  # fmt: skip
SIZES = 8
"""How many sizes `std.docking` tells apart."""
NEAR = 1e-6
"""By how much a rotation matrix may miss being one: files round."""


def import_catalogue(source: Source) -> Models:
    """The modules, or the scene, of a file. Raises SourceError."""
    reading = _CatalogueReading(source)
    reading.read()
    if reading.found:
        raise SourceError(reading.found)
    return reading.models


class _Unfit(Exception):
    """A value is not what it should be; the message says which."""


class _CatalogueReading:
    def __init__(self, source: Source) -> None:
        self.faults, self.models, self.names = Faults(source), Models(), GivenNames(STANDARD)
        self.meshes = MeshReader(source.path)
        self.found: list[Diagnostic] = []
        self.sizes: dict[str, int] = {}
        self.at = 0

    def read(self) -> None:
        told = self._json()
        if isinstance(told, dict) and "obstacles" in told:
            self.models.imports = ("std.rules",)
            for item in _list(told, "obstacles"):
                self._try(item, self._obstacle)
            for goal in _list(told, "goals"):
                self._leave(goal, f"goal `{_id(goal)}` is left out: state what the task is to reach")
            return
        modules = told.get("modules", [told]) if isinstance(told, dict) else told
        self.models.imports = ("std.docking", "std.rules")
        for item in modules if isinstance(modules, list) else []:
            self._try(item, self._module)

    def _json(self) -> Any:
        text = self.faults.source.text

        def refuse(word: str) -> float:
            if word == "NaN":
                place = max(text.find("NaN"), 0)
                raise SourceError([Diagnostic("E0019", "`NaN` is no number", self.faults.span(place, place + 3))])
            return -math.inf if word.startswith("-") else math.inf

        try:
            return json.loads(text, parse_constant=refuse)
        except json.JSONDecodeError as error:
            span = self.faults.span(error.pos, min(error.pos + 1, len(text)))
            raise SourceError([Diagnostic("E0019", f"this is not JSON from here on: {error.msg}", span)]) from None
        except (RecursionError, ValueError):
            message = "this is no JSON that can be read: nested too deeply, or with numbers too long"
            raise SourceError([Diagnostic("E0019", message, self.faults.span(0, 1))]) from None

    def _place(self, item: object) -> Span:
        """Where the ID of a module, body or joint stands."""
        pattern = rf'"ID"\s*:\s*"?{re.escape(_id(item))}"?'
        match = re.compile(pattern).search(self.faults.source.text, self.at)
        match = match or re.search(pattern, self.faults.source.text)
        return self.faults.span(*(match.span() if match else (0, 1)))

    def _leave(self, item: object, message: str) -> None:
        self.models.told.append(Diagnostic("W0019", message, self._place(item)))

    def _try(self, item: Any, read: Any) -> None:
        span = self._place(item)
        self.at = span.start if _id(item) else self.at
        try:
            read(item)
        except (_Unfit, OverflowError) as reason:
            self.found.append(Diagnostic("E0022", f"`{_id(item)}`: {reason}", span))
        except (TypeError, AttributeError, KeyError, ValueError, IndexError):
            message = f"`{_id(item)}` is not written as modules and scenes of CoBRA are"
            self.found.append(Diagnostic("E0019", message, span))

    def _module(self, item: dict[str, Any]) -> None:
        name = self.names.fresh(_id(item))
        bodies = {str(b["ID"]): b for b in _list(item, "bodies")}
        joints = {str(j["ID"]): j for j in _list(item, "joints")}
        if not bodies:
            raise _Unfit("a module has at least one body")
        if len(bodies) < len(_list(item, "bodies")) or len(joints) < len(_list(item, "joints")):
            raise _Unfit("two of its bodies, or two of its joints, have the same ID")
        below: dict[str, str] = {}
        for key, joint in joints.items():
            if str(joint["parent"]) not in bodies or str(joint["child"]) not in bodies:
                raise _Unfit(f"joint `{key}` joins a body that is not there")
            if str(joint["child"]) in below:
                raise _Unfit(f"body `{joint['child']}` hangs on two joints")
            below[str(joint["child"])] = str(joint["parent"])
        roots = [b for b in bodies if b not in below]
        if len(roots) != 1:
            raise _Unfit(f"a module has one body on which all others hang, here there are {len(roots)}")
        order = [roots[0]]
        for body in order:
            order += [child for child, parent in below.items() if parent == body]
        if len(order) < len(bodies):
            raise _Unfit("some of its bodies hang on themselves")
        parts: list[RobotPart] = [self._part(b, bodies[b]) for b in order]
        hinges = [h for key, joint in joints.items() for h in self._hinges(key, joint, parts)]
        ends, facts = self._ends(item, bodies, order)
        if ends:
            self.models.robots.append(RobotModel(name, tuple(parts), tuple(hinges), tuple(ends), tuple(facts)))
        else:
            self._leave(item, f"module `{_id(item)}` has no connector, and is left out")

    def _part(self, name: str, body: dict[str, Any]) -> RobotPart:
        mass = float(body.get("mass", 0.0))
        weight = None
        if 0 < mass < math.inf:
            com = [float(v) for v in body.get("r_com", body.get("com", (0.0, 0.0, 0.0)))]
            rows = [[float(v) for v in row] for row in body.get("inertia", [[0.0] * 3] * 3)]
            moments = (rows[0][0], rows[0][1], rows[0][2], rows[1][1], rows[1][2], rows[2][2])
            place = make((com[0], com[1], com[2]), (0.0, 0.0, 0.0, 1.0))
            _check([*com, *moments], "an inertia")
            weight = PartWeight(mass, place, moments)
        forms = [f for c in _list(body, "collision") for f in self._forms(body, c, IDENTITY)]
        return RobotPart(name, tuple(forms), weight)

    def _hinges(self, key: str, joint: dict[str, Any], parts: list[RobotPart]) -> list[Hinge]:
        kind = KINDS.get(str(joint.get("type", "revolute")))
        if kind is None:
            raise _Unfit(f"joint `{key}` is of type `{joint.get('type')}`")
        first, last = _pose(joint.get("poseParent")), _pose(joint.get("poseChild"))
        parent, child = str(joint["parent"]), str(joint["child"])
        if kind == "fixed":
            return [Hinge(key, "fixed", parent, child, compose(first, last))]
        limits = joint.get("limits", {})
        lower, upper = (float(limits.get(k, v)) for k, v in (("positionLower", -math.inf), ("positionUpper", math.inf)))
        if math.isinf(lower) or math.isinf(upper):
            if kind == "revolute":
                kind, lower, upper = "continuous", 0.0, 0.0
            else:
                self._leave(joint, f"joint `{key}` has no limits: it moves {FAR:g} m each way")
                lower, upper = max(lower, -FAR), min(upper, FAR)
        if not lower <= upper:
            raise _Unfit(f"the limits of joint `{key}` are empty: {lower:g} .. {upper:g}")
        speed, effort, growth = (
            value if 0 < value < math.inf else 0.0
            for value in (float(limits.get(k, math.inf)) for k in ("velocity", "peakTorque", "acceleration"))
        )
        middle = f"{key}.frame"
        parts.append(RobotPart(middle))
        axis = (0.0, 0.0, 1.0)
        return [
            Hinge(key, kind, parent, middle, first, axis, lower, upper, speed, effort, None, growth),
            Hinge(f"{key}.fixed", "fixed", middle, child, last),
        ]

    def _ends(
        self, item: dict[str, Any], bodies: Mapping[str, dict[str, Any]], order: Sequence[str]
    ) -> tuple[list[RobotEnd], list[str]]:
        names, ends, facts = GivenNames(), [], []
        for body in order:
            for connector in _list(bodies[body], "connectors"):
                gender = GENDERS.get(str(connector.get("gender", "h")).lower())
                if gender is None:
                    raise _Unfit(f"connector `{_id(connector)}` is of gender `{str(connector['gender'])[:40]}`")
                name = names.fresh(_id(connector))
                ends.append(RobotEnd(name, "connector", body, _pose(connector.get("pose"))))
                size = json.dumps([connector.get("type", ""), connector.get("size", [])])
                number = self.sizes.setdefault(size, len(self.sizes) + 1)
                facts.append(f"({gender} {name})")
                if number <= SIZES:
                    facts.append(f"(size{number} {name})")
                else:
                    self._leave(item, f"connector `{name}` is of a size more than {SIZES}: it docks to none")
        return ends, [*facts, *linked(ends)]

    def _obstacle(self, item: dict[str, Any]) -> None:
        frame = _pose(item.get("pose"))
        name = str(item.get("name") or f"obstacle_{_id(item)}")
        for shape in _list(item, "collision"):
            for form in self._forms(item, shape, frame):
                self.models.things.append(Thing("base", self.names.fresh(name), (form,)))

    def _forms(self, item: object, shape: dict[str, Any], frame: Pose) -> list[Form]:
        kind, given = str(shape.get("type", "")).lower(), shape.get("parameters", {})
        place = compose(frame, _pose(shape.get("pose")))
        if kind == "mesh":
            return self._mesh(item, given, place)
        if kind == "sphere":
            size: tuple[float, ...] = (_size(given, "r", "radius"),)
        elif kind in ("cylinder", "capsule"):
            size = _size(given, "r", "radius"), _size(given, "z", "length")
        elif kind == "box":
            size = float(given["x"]), float(given["y"]), float(given["z"])
        elif kind == "empty":
            return []
        else:
            self._leave(item, f"a shape `{kind}` of `{_id(item)}` has no counterpart, and is left out")
            return []
        _check(size, f"the size of a {kind}")
        if min(size) <= 0:
            self._leave(item, f"a {kind} of `{_id(item)}` has no volume, and is left out")
            return []
        return [Form(kind, size, place)]

    def _mesh(self, item: object, given: dict[str, Any], place: Pose) -> list[Form]:
        """The forms of a mesh, whose file is named from the file or, as packages are, from a folder above it."""
        name = str(given["file"]).strip()
        scale = given.get("scale", 1.0)
        sizes = [float(v) for v in (scale if isinstance(scale, list) else [scale] * 3)]
        if len(sizes) not in (1, 3):
            raise _Unfit("the scale of a mesh is one number or three")
        beside_it = Files().first([beside(self.faults.source.path, name)]) is not None
        named = name if beside_it or "://" in name or not name else f"package://{name}"
        try:
            forms, told = self.meshes.forms(named, sizes if len(sizes) == 3 else sizes * 3, place)
        except UnreadMesh as reason:
            if not reason.left_out:
                self.found.append(Diagnostic("E0515", str(reason), self._place(item)))
            else:
                self._leave(item, str(reason))
            return []
        self.models.told.append(Diagnostic("W0006", told, self._place(item)))
        return forms


def _size(given: dict[str, Any], short: str, long: str) -> float:
    """A size, which older files call by a longer name."""
    return float(given[short] if short in given else given[long])


def _id(item: object) -> str:
    """The ID of a module, of its header, or of a part."""
    if not isinstance(item, dict):
        return ""
    header = item.get("header")
    found = header.get("ID") if isinstance(header, dict) and "ID" not in item else item.get("ID")
    return re.sub(r'["\n]', "'", str("" if found is None else found))


def _list(item: dict[str, Any], key: str) -> list[dict[str, Any]]:
    found = item.get(key) or []
    if not isinstance(found, list) or not all(isinstance(x, dict) for x in found):
        raise _Unfit(f"`{key}` is no list of objects")
    return found


def _check(values: Sequence[float], what: str) -> None:
    if not all(map(math.isfinite, values)):
        raise _Unfit(f"{what} is not finite")


def _pose(rows: Any) -> Pose:
    """A pose from four rows of a homogeneous matrix."""
    if rows is None:
        return IDENTITY
    m = [[float(v) for v in row] for row in rows]
    if len(m) != 4 or any(len(row) != 4 for row in m):
        raise _Unfit("a pose is a matrix of 4 rows and 4 columns")
    _check([v for row in m for v in row], "a pose")
    columns = [[m[i][k] for i in range(3)] for k in range(3)]
    dots = [sum(a * b for a, b in zip(columns[i], columns[j], strict=True)) for i in range(3) for j in range(3)]
    cross = [columns[0][(k + 1) % 3] * columns[1][(k + 2) % 3] - columns[0][(k + 2) % 3] * columns[1][(k + 1) % 3]
             for k in range(3)]  # fmt: skip
    right = sum(a * b for a, b in zip(cross, columns[2], strict=True))
    if any(abs(d - (k % 4 == 0)) > NEAR * 100 for k, d in enumerate(dots)) or right < 0:
        raise _Unfit("the matrix of a pose is no rotation")
    q = _quaternion(m)
    return make((m[0][3], m[1][3], m[2][3]), (q[0], q[1], q[2], q[3]))


def _quaternion(m: list[list[float]]) -> list[float]:
    squares = [
        1 + m[0][0] - m[1][1] - m[2][2], 1 - m[0][0] + m[1][1] - m[2][2], 1 - m[0][0] - m[1][1] + m[2][2],
        1 + m[0][0] + m[1][1] + m[2][2],
    ]  # fmt: skip
    most = max(range(4), key=lambda k: squares[k])
    q = [0.0] * 4
    q[most] = squares[most]
    if most == 3:
        q[0], q[1], q[2] = m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1]
    else:
        i, j, k = most, (most + 1) % 3, (most + 2) % 3
        q[j], q[k], q[3] = m[j][i] + m[i][j], m[k][i] + m[i][k], m[k][j] - m[j][k]
    norm = math.hypot(*q)
    return [v / norm for v in q]
