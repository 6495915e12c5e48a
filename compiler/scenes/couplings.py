"""Coupled joints: a follower is always a multiple of its leader plus an offset.

A coupling to a joint that itself follows becomes one to the joint that follows none, and what the limits, speeds and
accelerations of followers allow narrows those of their leader: whoever moves the leader within its own keeps all.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

from ...langs import syntax
from ...langs.frozen import dataclass
from .. import ir
from ..checks.context import Context
from ..checks.kinds import ANGLE, LENGTH, NUMBER, Kind
from ..checks.names import Scope, names_in
from ..checks.values import number

DIMENSIONS = {ir.JointKind.REVOLUTE: (0, 1), ir.JointKind.PRISMATIC: (1, 0)}
"""Length and angle in the value of a joint."""
WORDS = {ir.JointKind.REVOLUTE: "turns", ir.JointKind.PRISMATIC: "slides"}


class BadCoupling(Exception):
    """The couplings of a module contradict each other or its limits. `joint` is the follower to blame; `narrow` tells
    that its limits leave its leader nothing."""

    def __init__(self, joint: str, message: str, help: str | None = None, narrow: bool = False) -> None:
        super().__init__(message)
        self.joint, self.help, self.narrow = joint, help, narrow


@dataclass(frozen=True, slots=True)
class StatedCoupling:
    """What a text says: a joint is `factor` times joint `leader` plus `offset` (rad or m); NaN where parameters have no
    values yet."""

    leader: str
    factor: float
    offset: float


def couple(joints: Sequence[ir.Joint], stated: Mapping[str, StatedCoupling]) -> tuple[ir.Joint, ...]:
    """The joints of a module with what is `stated` of followers, by name. Raises BadCoupling."""
    names, made = [j.name for j in joints], list(joints)
    at = {name: index for index, name in enumerate(names)}
    known = [(j.name, j.follows) for j in joints]
    stated = {n: StatedCoupling(names[f.leader], f.factor, f.offset) for n, f in known if f is not None} | {**stated}
    resolved = _resolved(stated)
    for name, found in resolved.items():
        joint, leader = made[at[name]], made[at[found.leader]]
        if leader.passive != joint.passive:
            made[at[name]] = replace(joint, passive=leader.passive)
        made[at[found.leader]] = _narrowed(leader, joint, found)
    for name, found in resolved.items():
        ahead = at[found.leader]
        home = found.factor * made[ahead].home + found.offset
        made[at[name]] = replace(made[at[name]], home=home, follows=ir.Coupling(ahead, found.factor, found.offset))
    return tuple(made)


def _resolved(stated: Mapping[str, StatedCoupling]) -> dict[str, StatedCoupling]:
    """The coupling of each joint to one that follows none."""
    found: dict[str, StatedCoupling] = {}
    for name in stated:
        way = {name: None}
        now = stated[name].leader
        while now in stated and now not in found:
            if now in way:
                passed = list(way)
                ring = " follows ".join(f"`{n}`" for n in [*passed[passed.index(now) :], now])
                message = f"joints follow each other in a circle: {ring}"
                if len(passed) == 1:
                    message = f"joint `{name}` follows itself"
                raise BadCoupling(name, message, "one of them must be free to move")
            way[now] = None
            now = stated[now].leader
        for follower in reversed(way):
            own = stated[follower]
            ahead = found.get(own.leader, StatedCoupling(own.leader, 1.0, 0.0))
            factor, offset = own.factor * ahead.factor, own.factor * ahead.offset + own.offset
            if factor == 0.0 or math.isinf(factor) or math.isinf(offset):
                message = f"joint `{follower}` follows `{ahead.leader}` {factor:g} times as far, {offset:g} apart"
                raise BadCoupling(follower, message, "it must be a number other than 0 and infinity")
            found[follower] = StatedCoupling(ahead.leader, factor, offset)
    return {name: found[name] for name in stated}


def _narrowed(leader: ir.Joint, follower: ir.Joint, coupling: StatedCoupling) -> ir.Joint:
    """The leader within what the follower's limits allow it."""
    ends = sorted((limit - coupling.offset) / coupling.factor for limit in (follower.lower, follower.upper))
    lower, upper, size = max(leader.lower, ends[0]), min(leader.upper, ends[1]), abs(coupling.factor)
    if lower >= upper:
        message = f"the limits of `{leader.name}` and of `{follower.name}`, which follows it, leave nothing to move in"
        raise BadCoupling(follower.name, message, f"`{leader.name}` would be in {lower:g} .. {upper:g}", narrow=True)
    speed, acceleration = min(leader.speed, follower.speed / size), leader.acceleration
    if math.isfinite(follower.acceleration):
        acceleration = min(acceleration, follower.acceleration / size)
    jerk = min(leader.jerk, follower.jerk / size)
    return replace(leader, lower=lower, upper=upper, speed=speed, acceleration=acceleration, jerk=jerk)


def text_couplings(
    context: Context, scope: Scope, items: Sequence[syntax.ModuleItem], joints: Sequence[ir.Joint]
) -> tuple[ir.Joint, ...] | None:
    """The joints of a module type with the couplings among its `items`; None after reporting what is wrong, or where
    values are missing."""
    couplings = {i.name: i for i in items if isinstance(i, syntax.CouplingItem)}
    if not couplings:
        return tuple(joints)
    known, stated, complete = {j.name: j for j in joints}, dict[str, StatedCoupling](), True
    for item in couplings.values():
        found = _stated(context, scope, item, known)
        complete = complete and found is not None
        stated |= {item.name: found} if found is not None else {}
    if not complete:
        return None
    try:
        coupled = couple(joints, stated)
        valued = all(math.isfinite(s.factor + s.offset) for s in stated.values())
        return _at_home(context, couplings, coupled) if valued else None
    except BadCoupling as mistake:
        blamed = couplings.get(mistake.joint) or next(iter(couplings.values()))
        context.findings.report("E0521", blamed.span, str(mistake), help=mistake.help)
        return None


def _at_home(
    context: Context, couplings: Mapping[str, syntax.CouplingItem], joints: tuple[ir.Joint, ...]
) -> tuple[ir.Joint, ...] | None:
    """The joints, if the leaders' values at home are within what their followers leave them."""
    for joint in joints:
        leader = joints[joint.follows.leader] if joint.follows is not None else joint
        if not leader.lower <= leader.home <= leader.upper:
            message = f"at home joint `{leader.name}` is {leader.home:g}, and puts `{joint.name}` outside its limits"
            help = f"write `home` behind `{leader.name}`, between {leader.lower:g} and {leader.upper:g}"
            if joint.name in couplings:
                context.findings.report("E0521", couplings[joint.name].span, message, help=help)
                return None
    return joints


def _stated(
    context: Context, scope: Scope, item: syntax.CouplingItem, joints: Mapping[str, ir.Joint]
) -> StatedCoupling | None:
    """What the text says of one follower; None after reporting what is wrong, or where values are missing."""
    findings = context.findings
    if item.name not in joints:
        findings.unknown("E0119", "joint", item.name, findings.word(item.span, item.name), joints)
        return None
    joint = joints[item.name]
    reader = _Linear(context, scope, joints, ANGLE if joint.kind == ir.JointKind.REVOLUTE else LENGTH)
    leader, factor, offset = reader.read(item.value)
    if reader.wrong:
        return None
    if leader is None:
        message = f"joint `{item.name}` follows no joint: there is none in this value"
        known = ", ".join(f"`{n}`" for n in joints if n != item.name)
        findings.report("E0521", item.value.span, message, help=f"known here: {known}" if known else None)
        return None
    if factor == 0:
        message = f"joint `{item.name}` does not move with `{leader}`: it follows it 0 times"
        findings.report("E0521", item.value.span, message)
        return None
    if not _fits(context, item, joint, joints[leader], reader):
        return None
    return StatedCoupling(leader, math.nan if factor is None else factor, math.nan if offset is None else offset)


def _fits(context: Context, item: syntax.CouplingItem, joint: ir.Joint, leader: ir.Joint, reader: _Linear) -> bool:
    """Whether the factor has the unit that makes the leader's value one of the follower; reports where not."""
    ahead, own = DIMENSIONS[leader.kind], DIMENSIONS[joint.kind]
    if reader.dimension == (own[0] - ahead[0], own[1] - ahead[1]):
        return True
    if joint.kind == leader.kind and reader.united is not None:
        term, kind = reader.united
        context.findings.report("E0203", term.span, f"the factor of a joint must be a plain number, not {kind}")
        return False
    message = f"joint `{joint.name}` {WORDS[joint.kind]}, and `{leader.name}`, which it follows, {WORDS[leader.kind]}"
    ratio = "5 mm / 360 deg" if joint.kind == ir.JointKind.PRISMATIC else "360 deg / 5 mm"
    help = f"say how far for how much, as in `joint {joint.name} = {leader.name} * {ratio}`"
    context.findings.report("E0521", item.span, message, help=help)
    return False


Part = tuple[str | None, float | None, float | None]
"""The joint of a linear term, its factor, and what is added; numbers are None where values are missing."""


class _Linear:
    """Reads a term as a multiple of one joint plus a value."""

    def __init__(self, context: Context, scope: Scope, joints: Mapping[str, ir.Joint], kind: Kind) -> None:
        self.context, self.scope, self.joints, self.kind = context, scope, joints, kind
        self.wrong = False
        self.dimension = (0, 0)
        """How often the factor of the joint holds a length, and an angle."""
        self.united: tuple[syntax.Term, Kind] | None = None
        """A part of that factor that has a unit."""

    def read(self, term: syntax.Term) -> Part:
        match term:
            case syntax.Name(name=name) if name in self.joints and name not in self.scope.entries:
                return name, 1.0, 0.0
            case syntax.Negate(operand=operand):
                return self._scaled(self.read(operand), -1.0)
            case syntax.Binary(operator="+" | "-" as operator, left=left, right=right):
                sign = 1.0 if operator == "+" else -1.0
                return self._sum(term, self.read(left), self._scaled(self.read(right), sign))
            case syntax.Binary(operator="*" | "/" as operator, left=left, right=right) if self._moves(term):
                return self._product(term, operator, left, right)
        if self._moves(term):
            return self._refuse(term, "this is no multiple of one joint plus a value")
        for name in names_in(term) - set(self.scope.names()):
            self.context.findings.unknown("E0119", "joint", name, term.span, self.joints)
            self.wrong = True
            return None, 0.0, 0.0
        return None, 0.0, number(self.context, self.scope, term, self.kind, "what is added to a joint")

    def _moves(self, term: syntax.Term) -> bool:
        return bool(names_in(term) & self.joints.keys() - self.scope.entries.keys())

    @staticmethod
    def _scaled(part: Part, by: float | None) -> Part:
        leader, *numbers = part
        factor, offset = (None if by is None or number is None else by * number for number in numbers)
        return leader, factor, offset

    def _sum(self, term: syntax.Term, first: Part, second: Part) -> Part:
        leaders = {p[0] for p in (first, second)} - {None}
        if len(leaders) > 1:
            return self._refuse(term, "a joint follows one other joint, not two")
        both = zip(first[1:], second[1:], strict=True)
        factor, offset = (None if a is None or b is None else a + b for a, b in both)
        return next(iter(leaders), None), factor, offset

    def _product(self, term: syntax.Term, operator: str, left: syntax.Term, right: syntax.Term) -> Part:
        if self._moves(right) and (operator == "/" or self._moves(left)):
            return self._refuse(term, "this is no multiple of one joint plus a value")
        moving, plain = (right, left) if self._moves(right) else (left, right)
        by = self._factor(plain, 1 if operator == "*" else -1)
        if operator == "/" and by is not None:
            if by == 0:
                return self._refuse(plain, "a joint cannot be divided by 0")
            by = 1 / by
        return self._scaled(self.read(moving), by)

    def _factor(self, term: syntax.Term, sign: int) -> float | None:
        """The value of what a joint is multiplied with, or divided by."""
        kind = self.context.check_term(self.context, self.scope, term).kind
        if not kind.known:
            self.wrong = True
            return None
        if kind not in (LENGTH, ANGLE):
            self.wrong = self.wrong or kind != NUMBER
            return number(self.context, self.scope, term, NUMBER, "the factor of a joint")
        length, angle = self.dimension
        self.dimension = (length + sign, angle) if kind == LENGTH else (length, angle + sign)
        self.united = self.united or (term, kind)
        return number(self.context, self.scope, term, kind, "the factor of a joint")

    def _refuse(self, term: syntax.Term, message: str) -> Part:
        if not self.wrong:
            help = "write, for one, `joint j2 = -0.5 * j1 + 10 deg`"
            self.context.findings.report("E0521", term.span, message, help=help)
        self.wrong = True
        return None, 0.0, 0.0
