"""Kinds of values and how they combine: plain numbers, lengths, angles, vectors, objects and chains."""

from __future__ import annotations

from ...langs.frozen import dataclass


@dataclass(frozen=True, slots=True)
class Kind:
    """`name` is number, length, angle, time, speed, …, vector, rows, wrench, pose, object, chain or unknown
    (after an error, to keep quiet about what follows). `type` is the object type, or the element type of a chain;
    `ends` the type of a chain's effectors."""

    name: str
    type: str = ""
    ends: str = ""

    @property
    def is_scalar(self) -> bool:
        return self.name in SCALARS

    @property
    def known(self) -> bool:
        return self.name != "unknown"

    def __str__(self) -> str:
        if self.name == "object":
            return f"an object of type `{self.type}`"
        return PHRASES[self.name]


SCALARS = ("number", "length", "angle", "time", "speed", "angular speed", "acceleration", "angular acceleration",
           "jerk", "angular jerk", "mass", "density", "force", "torque", "inertia")  # fmt: skip
PHRASES = {
    "number": "a plain number",
    "length": "a length",
    "angle": "an angle",
    "time": "a time",
    "speed": "a speed",
    "angular speed": "an angular speed",
    "acceleration": "an acceleration",
    "angular acceleration": "an angular acceleration",
    "jerk": "a jerk",
    "angular jerk": "an angular jerk",
    "mass": "a mass",
    "density": "a density",
    "force": "a force",
    "torque": "a torque",
    "inertia": "a moment of inertia",
    "vector": "a vector",
    "rows": "several lengths",
    "pose": "a pose",
    "wrench": "a wrench",
    "joint": "a joint",
    "object": "an object",
    "chain": "a chain",
    "letter": "one of the letters x, y, z",
    "unknown": "something unknown",
}
SIZES = {"vector": 3, "rows": 4, "pose": 6, "wrench": 6}

UNKNOWN = Kind("unknown")
NUMBER = Kind("number")
LENGTH = Kind("length")
ANGLE = Kind("angle")
VECTOR = Kind("vector")
TIME = Kind("time")
SPEED = Kind("speed")
ANGULAR_SPEED = Kind("angular speed")
ACCELERATION = Kind("acceleration")
ANGULAR_ACCELERATION = Kind("angular acceleration")
JERK = Kind("jerk")
ANGULAR_JERK = Kind("angular jerk")
MASS = Kind("mass")
DENSITY = Kind("density")
FORCE = Kind("force")
TORQUE = Kind("torque")
INERTIA = Kind("inertia")
PHYSICAL = ("mass", "density", "force", "torque", "inertia")
VALUE_TYPES = {"int": NUMBER, "real": NUMBER, "length": LENGTH, "angle": ANGLE, "time": TIME, "speed": SPEED,
               "mass": MASS, "density": DENSITY, "force": FORCE, "torque": TORQUE, "inertia": INERTIA}  # fmt: skip
EXAMPLES = {"length": "m", "angle": "rad", "time": "s", "speed": "m/s", "angular speed": "rad/s",
            "acceleration": "m/s^2", "angular acceleration": "rad/s^2", "jerk": "m/s^3",
            "angular jerk": "rad/s^3", "mass": "kg", "density": "kg/m^3", "force": "N",
            "torque": "N m", "inertia": "kg m^2"}  # fmt: skip
RATES = {LENGTH: SPEED, ANGLE: ANGULAR_SPEED, SPEED: ACCELERATION, ANGULAR_SPEED: ANGULAR_ACCELERATION,
         ACCELERATION: JERK, ANGULAR_ACCELERATION: ANGULAR_JERK}  # fmt: skip
"""What a kind becomes when it is divided by a time."""


def size_of(kind: Kind) -> int:
    """How many scalar rows a value of this kind has."""
    return SIZES.get(kind.name, 1)


def added(left: Kind, right: Kind, left_literal: bool, right_literal: bool) -> Kind | None:
    """The kind of a sum or difference, or None where the two do not mix. A plain literal number passes for a length."""
    if not (left.known and right.known):
        return UNKNOWN
    if left == right and (left.is_scalar or left.name in ("vector", "rows", "wrench")):
        return left
    names = {left.name, right.name}
    if names == {"number", "length"}:
        literal = left_literal if left.name == "number" else right_literal
        return LENGTH if literal else None
    if names in ({"rows", "length"}, {"rows", "number"}):
        return Kind("rows")
    return None


def multiplied(left: Kind, right: Kind) -> Kind | None:
    """The kind of a product: a plain number scales anything, a length scales a vector, a time makes a way of a
    speed, a lever a torque of a force."""
    if not (left.known and right.known):
        return UNKNOWN
    for one, other in ((left, right), (right, left)):
        if one.name == "number" and (other.is_scalar or other.name in ("vector", "rows", "wrench")):
            return other
        if one.name == "length" and other.name == "vector":
            return other
        way = next((w for w, rate in RATES.items() if rate == one), None)
        if way is not None and other == TIME:
            return way
        if one == FORCE and other == LENGTH:
            return TORQUE
    return None


def divided(left: Kind, right: Kind) -> Kind | None:
    """The kind of a quotient: by a plain number, of two values of one kind, or of a way, a time and a speed."""
    if not (left.known and right.known):
        return UNKNOWN
    if right.name == "number" and (left.is_scalar or left.name in ("vector", "rows", "wrench")):
        return left
    if left == right and left.is_scalar:
        return NUMBER
    if left.name == "vector" and right.name == "length":
        return left
    if left == TORQUE and right in (LENGTH, FORCE):
        return FORCE if right == LENGTH else LENGTH
    if right == TIME:
        return RATES.get(left)
    return TIME if RATES.get(left) == right else None
