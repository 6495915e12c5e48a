"""The built-in functions of the language, with what they take and give. One table for checker, back ends and docs.

Kinds: "number" (plain), "length", "angle", "vector", "pose", "rows" (several lengths), "object", "chain", "letter";
"same" is the kind of the arguments, "rows" where one of two is; "joint" is a joint of a thing, such as `X.j2`.
A "length" and a "number" mix freely only when one of them is a plain literal number.
"""

from __future__ import annotations

from ..langs.frozen import dataclass


@dataclass(frozen=True, slots=True)
class Builtin:
    """`overloads` lists argument kinds; `rows` is the size of the result. `place` says where it may stand: "scene"
    (text that is evaluated while the scene is built), "rule" (conditions and heuristics, evaluated on the scene at
    the start), "motion" (motion predicates, on moving frames), or several."""

    overloads: tuple[tuple[str, ...], ...]
    result: str
    rows: int
    place: tuple[str, ...]
    doc: str


def _f(overloads: str, result: str, rows: int, place: str, doc: str) -> Builtin:
    parsed = tuple(tuple(o.split()) for o in overloads.split("|"))
    return Builtin(parsed, result, rows, tuple(place.split()), doc)


FUNCTIONS: dict[str, Builtin] = {
    "distance": _f("object object", "length", 1, "rule",
                   "smallest distance between two shapes at the start, 0 when they overlap"),
    "stride": _f("object object length", "length", 1, "rule",
                 "smallest distance between the top faces of two things at the start, each shrunk by the inset"),
    "reach": _f("object object|chain", "length", 1, "rule",
                "how far apart two effectors of one module, or the ends of a chain, can be at most"),
    "length": _f("chain", "number", 1, "rule", "how many modules a chain has"),
    "radius": _f("object", "length", 1, "rule motion", "radius of a round shape, or of the sphere around another one"),
    "jitter": _f("length|angle|time|speed", "same", 1, "scene",
                 "a random value between minus and plus the argument, by the seed"),
    "random": _f("number number|length length|angle angle|time time|speed speed", "same", 1, "scene",
                 "a random number between two bounds, by the seed"),
    "sqrt": _f("number", "number", 1, "scene rule motion", "square root"),
    "abs": _f("number|length|angle|force|torque|wrench", "same", 1, "scene rule motion", "absolute value"),
    "least": _f("number number|length length|angle angle|rows rows|rows length|length rows", "same", 1, "scene motion",
                "the smaller of two values; of several lengths, of each"),
    "sin": _f("angle", "number", 1, "scene rule motion", "sine"),
    "cos": _f("angle", "number", 1, "scene rule motion", "cosine"),
    "floor": _f("number", "number", 1, "scene rule", "largest integer that is not above the argument"),
    "position": _f("object", "vector", 3, "motion", "origin of the frame, in the world"),
    "axis": _f("object letter", "vector", 3, "motion", "unit axis x, y or z of the frame, in the world"),
    "pose": _f("object object", "pose", 6, "motion", "pose of the first frame relative to the second; only in keep"),
    "gap": _f("object object", "length", 1, "motion", "signed distance between two shapes, negative when they overlap"),
    "top": _f("object", "length", 1, "motion", "height of the highest point of the shape"),
    "bottom": _f("object", "length", 1, "motion", "height of the lowest point of the shape"),
    "inside": _f("object object", "rows", 4, "motion",
                 "how far the centre of the first shape lies inside the top face of the second, to its four sides"),
    "mass": _f("object", "number", 1, "motion",
               "mass of the body, or of the module that the object is part of, in kilograms at the density of water"),
    "centre": _f("object", "vector", 3, "motion",
                 "centre of mass of the body, or of the module that the object is part of, in the world"),
    "load": _f("object|chain", "number", 1, "rule motion",
               "the worst ratio of load, times the safety, to strength: of what an object or its module has, at rest;"
               " in a rule at the start, or of a chain in the worst of all postures, held by its first end"),
    "torque": _f("joint", "torque", 1, "rule motion",
                 "what the drive of a joint such as `X.j2` gives at rest, in N m, of a prismatic one in N; 0 where the"
                 " module of X has no such joint; in a rule at the start"),
    "wrench": _f("object object", "wrench", 6, "motion",
                 "force and moment that the first of a kept pair puts on the second at rest, along and about the axes"
                 " of where they meet, the third one along the normal; 0 where nothing keeps them together"),
    "dot": _f("vector vector", "number", 1, "motion", "inner product"),
    "cross": _f("vector vector", "vector", 3, "motion", "cross product"),
    "norm": _f("vector", "length", 1, "motion", "length of a vector"),
}
