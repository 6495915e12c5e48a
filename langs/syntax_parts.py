"""The syntax tree: the parts of modules, and what parts weigh, what joints bear, and how ends and bodies hold."""

from __future__ import annotations

from .frozen import dataclass
from .syntax_terms import Call, Node, Term, Text


@dataclass(frozen=True, slots=True)
class Stated(Node):
    """`mass 0.5 kg`, `torque 38 N m`: `word` is mass, density, torque, force, bearing, rotor or brake."""

    word: str
    value: Term


@dataclass(frozen=True, slots=True)
class Holds(Node):
    """`holds latch(force 110 N, shear 50 N)`: the manner, and what it bears, by name."""

    manner: str
    strengths: tuple[tuple[str, Term], ...]


Physical = Stated | Holds


@dataclass(frozen=True, slots=True, kw_only=True)
class PhysicalNode(Node):
    """A part of a module or scene that may state what it weighs, bears and holds."""

    physics: tuple[Physical, ...] = ()


@dataclass(frozen=True, slots=True)
class EffectorItem(PhysicalNode):
    """`effector A: port sphere(0.05 m) at (0, 0, 0) normal (0, 0, -1)`, or in a module from a URDF, with the name of a
    link, `effector A: port "tool0" sphere(4 cm)`. Without `shape` it is the shape of the link."""

    name: str
    type: str | None
    link: Text | None
    shape: Call | None
    at: Term | None
    normal: Term | None


@dataclass(frozen=True, slots=True)
class JointItem(PhysicalNode):
    """`joint j2: revolute(y) in -120 deg .. 120 deg home 0.6 rad speed 2 rad/s acceleration 5 rad/s^2`, or with
    vectors of two lengths as limits `joint drive: planar(x, y) in (-5 m, -5 m) .. (5 m, 5 m)`; `passive` behind it
    where the joint has no drive. One that another file describes has no kind: `joint "left" in 0 rad .. 1 rad`."""

    name: str
    kind: str | None
    axes: tuple[Term, ...]
    lower: Term | None
    upper: Term | None
    home: Term | None
    speed: Term | None
    acceleration: Term | None
    jerk: Term | None
    passive: bool


@dataclass(frozen=True, slots=True)
class CouplingItem(Node):
    """`joint j2 = -j1 + 10 deg`: what the joint `name` of the module always is, by another one."""

    name: str
    value: Term


@dataclass(frozen=True, slots=True)
class LinkItem(PhysicalNode):
    """`link 0.15 * size: capsule(0.04 m)`: go `length` metres along z, or by a vector, with that shape between."""

    length: Term
    shape: Call | None
