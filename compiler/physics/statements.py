"""Clauses about weight and strength, as numbers: `mass 2 kg`, `torque 38 N m`, `holds latch(force 110 N)`."""

from __future__ import annotations

from ...langs import syntax
from ...langs.diagnostics import did_you_mean
from ...langs.frozen import dataclass
from ...langs.source import Span
from ...langs.syntax_parts import PhysicalNode
from ..checks.context import Context
from ..checks.kinds import DENSITY, EXAMPLES, FORCE, INERTIA, MASS, NUMBER, TORQUE, Kind
from ..checks.names import Scope
from ..checks.values import number
from .records import MANNERS, Hold

UNITS: dict[str, Kind] = {
    "mass": MASS, "density": DENSITY, "torque": TORQUE, "force": FORCE, "bearing": TORQUE, "rotor": INERTIA,
    "brake": TORQUE,
}  # fmt: skip
STRENGTHS: dict[str, Kind] = {"force": FORCE, "shear": FORCE, "moment": TORQUE, "twist": TORQUE, "friction": NUMBER}
LARGEST: dict[str, float] = {"mass": 1e6, "density": 1e5, "friction": 100.0, "inertia": 1e6}
"""A thousand tonnes, several times the heaviest metal, and the like: more is a slip of the unit, and beyond it the
sums of a robot's weights lose the digits that its smallest part needs. Forces and torques end at 1e9."""


@dataclass(frozen=True, slots=True)
class StatedPart:
    """What a part states, in SI; None where it is silent. `spans` tell where."""

    mass: float | None
    density: float | None
    torque: float | None
    bearing: float | None
    rotor: float | None
    brake: float | None
    holds: tuple[Hold, ...]
    span: Span | None

    def weight(self, volume: float) -> float | None:
        """Kilograms of a part of that volume, m³."""
        return self.density * volume if self.density is not None else self.mass


def stated(context: Context, scope: Scope, item: PhysicalNode, allowed: tuple[str, ...], what: str) -> StatedPart:
    """What the clauses of a part say. Reports those that `what`, such as "a link", does not have, that are said twice,
    and values that cannot be."""
    found: dict[str, float | None] = {}
    holds: list[Hold] = []
    span: Span | None = None
    for clause in item.physics:
        if isinstance(clause, syntax.Holds):
            holds += _hold(context, scope, clause, holds, allowed, what)
            continue
        if clause.word not in allowed:
            said = ", ".join(f"`{a}`" for a in allowed)
            context.findings.report("E0522", clause.span, f"{what} states no {clause.word}", help=f"it states {said}")
            continue
        key = "torque" if clause.word == "force" else clause.word
        if key in found or (key in ("mass", "density") and {"mass", "density"} & set(found)):
            help = "state the mass or the density" if key in ("mass", "density") else "leave one out"
            context.findings.report("E0522", clause.span, f"the {clause.word} of {what} is said twice", help=help)
            continue
        slides = clause.word == "brake" and "force" in allowed
        unit = FORCE if slides else UNITS[clause.word]
        found[key] = _value(context, scope, clause.value, unit, f"the {clause.word} of {what}")
        span = clause.span if clause.word in ("torque", "force") else span or clause.span
    get = found.get
    strengths = get("torque"), get("bearing"), get("rotor"), get("brake")
    return StatedPart(get("mass"), get("density"), *strengths, tuple(holds), span)


def _hold(
    context: Context, scope: Scope, clause: syntax.Holds, before: list[Hold], allowed: tuple[str, ...], what: str
) -> list[Hold]:
    report = context.findings.report
    where = context.findings.word(clause.span, clause.manner)
    if "holds" not in allowed:
        report("E0522", clause.span, f"{what} holds nothing", help="effectors and bodies hold")
        return []
    if clause.manner not in MANNERS:
        help = did_you_mean(clause.manner, MANNERS) or f"ends hold as {', '.join(MANNERS)}"
        report("E0522", where, f"nothing holds as `{clause.manner}`", help=help)
        return []
    if any(h.manner == clause.manner for h in before):
        report("E0522", where, f"{what} says twice how it holds as {clause.manner}", help="leave one out")
        return []
    numbers: dict[str, float] = {}
    for name, term in clause.strengths:
        if name not in STRENGTHS:
            help = did_you_mean(name, STRENGTHS) or f"there are {', '.join(STRENGTHS)}"
            report("E0522", context.findings.word(clause.span, name), f"there is no strength `{name}`", help=help)
        elif name in numbers:
            where = context.findings.word(clause.span, name, 1)
            report("E0522", where, f"`{name}` is said twice", help="leave one out")
        else:
            value = _value(context, scope, term, STRENGTHS[name], f"the {name} of a {clause.manner}")
            if value is not None:
                numbers[name] = value
    return [Hold(clause.manner, **numbers, span=clause.span)]


def _value(context: Context, scope: Scope, term: syntax.Term, kind: Kind, what: str) -> float | None:
    """A positive number of that kind, or None."""
    value = number(context, scope, term, kind, what)
    if value is None:
        return None
    unit = f" {EXAMPLES[kind.name]}" if kind.name in EXAMPLES else ""
    if value <= 0.0:
        help = "leave it out where nothing is known: then there is no limit"
        if kind in (MASS, DENSITY):
            help = "what has no weight of its own gets a small one, such as `1 g`"
        context.findings.report("E0522", term.span, f"{what} must be positive, not {value:g}{unit}", help=help)
        return None
    most = LARGEST.get("friction" if kind == NUMBER else kind.name, 1e9)
    if value > most:
        context.findings.report("E0522", term.span, f"{what} is more than {most:g}{unit}", help="look at its unit")
        return None
    return value
