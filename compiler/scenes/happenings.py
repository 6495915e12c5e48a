"""What happens in a scene while a plan is executed: bodies that move on their own, modules that break down."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ...langs import syntax
from ...langs.diagnostics import Diagnostic, did_you_mean
from ...langs.frozen import dataclass
from ...langs.source import Span
from .. import ir
from ..checks.context import Context
from ..checks.findings import Findings
from ..checks.kinds import LENGTH, SPEED, TIME
from ..checks.names import Scope
from ..checks.terms import check_term
from ..checks.values import number, vector
from ..courses import centre_at
from ..poses import position

BREAKDOWNS = tuple(ir.BreakdownKind)


@dataclass(frozen=True, slots=True)
class Way:
    """A course as the text gives it: `steps` are measured from where the body is when it starts, metres."""

    body: str
    start: float
    steps: tuple[ir.Vec3, ...]
    speed: float
    returns: bool
    span: Span


def check_way(context: Context, scope: Scope, item: syntax.CourseItem | syntax.DisturbanceItem) -> Way | None:
    """A body's own motion, or None where values are missing or wrong."""
    if isinstance(item, syntax.CourseItem):
        body = _thing(context, scope, item.body, "moves")
        steps = [_step(context, scope, point, "a point of a course") for point in item.points]
        speed = number(context, scope, item.speed, SPEED, "the speed of a course")
        start = 0.0 if item.start is None else number(context, scope, item.start, TIME, "the start of a course")
        returns = item.returns
        if speed is not None and speed <= 0:
            message = f"the speed of a course must be positive, not {speed:g} m/s"
            context.findings.report("E0516", item.speed.span, message)
            speed = None
    else:
        body = _thing(context, scope, item.body, "disturb")
        steps = [_step(context, scope, item.by, "a disturbance")]
        speed, returns = 0.0, False
        start = number(context, scope, item.time, TIME, "the time of a disturbance")
    when = item.start if isinstance(item, syntax.CourseItem) else item.time
    known = tuple(s for s in steps if s is not None)
    if not _not_negative(context, "E0516", when, start) or body is None or len(known) < len(steps):
        return None
    if start is None or speed is None:
        return None
    if not any(any(abs(x) > 0 for x in step) for step in known):
        context.findings.report("E0516", item.span, f"`{body}` stays where it is", help="no step of its way leads away")
        return None
    return Way(body, start, known, speed, returns, item.span)


def check_breakdown(context: Context, scope: Scope, item: syntax.BreakdownItem) -> ir.Breakdown | None:
    """A module that fails, or None where values are missing or wrong."""
    module = _thing(context, scope, item.module, "fail")
    time = number(context, scope, item.time, TIME, "the time of a breakdown")
    if item.kind not in BREAKDOWNS:
        where = context.findings.word(item.span, item.kind)
        help = did_you_mean(item.kind, BREAKDOWNS) or "a module fails by being `locked` or `gone`"
        context.findings.report("E0517", where, f"unknown kind of breakdown `{item.kind}`", help=help)
        return None
    if not _not_negative(context, "E0517", item.time, time) or module is None or time is None:
        return None
    return ir.Breakdown(module, time, ir.BreakdownKind(item.kind), item.span)


def unseen(world: ir.World) -> Diagnostic | None:
    """The warning that a plan for the start of the scene does not see what happens later."""
    happenings: list[ir.Course | ir.Breakdown] = [*world.courses, *world.breakdowns]
    if not happenings:
        return None
    first = min(happenings, key=lambda h: h.start if isinstance(h, ir.Course) else h.time)
    message = "this scene moves, and the plan is for the scene as it is at time 0"
    return Diagnostic("W0008", message, first.span, help="`tamplang run` plans while the scene moves")


def _thing(context: Context, scope: Scope, term: syntax.Term, word: str) -> str | None:
    """The name of the body that `moves` or `disturb` speaks of, or of the module that `fail` speaks of."""
    typed = check_term(context, scope, term)
    if not typed.kind.known:
        return None
    module = typed.kind.name == "object" and context.library.is_a(typed.kind.type, "module")
    body = typed.kind.name == "object" and not module and not context.library.is_a(typed.kind.type, "effector")
    fits = module if word == "fail" else body
    if fits and isinstance(typed.term, ir.Object):
        return typed.term.name
    code, wanted = ("E0517", "a module") if word == "fail" else ("E0516", "a body")
    help = None
    if word != "fail" and module:
        help = "robots move by their plan; `fail` breaks a module down"
    elif word == "fail" and body:
        help = "`moves` and `disturb` move a body"
    context.findings.report(code, term.span, f"`{word}` needs {wanted}, not {typed.kind}", help=help)
    return None


def _step(context: Context, scope: Scope, term: syntax.Term, what: str) -> ir.Vec3 | None:
    step = vector(context, scope, term, 3, LENGTH, what)
    return None if step is None else (step[0], step[1], step[2])


def _not_negative(context: Context, code: str, term: syntax.Term | None, time: float | None) -> bool:
    if term is not None and time is not None and time < 0:
        context.findings.report(code, term.span, f"nothing happens before the start: {time:g} s is negative")
        return False
    return True


def courses(findings: Findings, bodies: Mapping[str, ir.Body], ways: Sequence[Way]) -> tuple[ir.Course, ...]:
    """The courses of all bodies with their points in the world. Reports two of one body that start together."""
    found: dict[str, list[ir.Course]] = {}
    for way in sorted(ways, key=lambda w: w.start):
        own = found.setdefault(way.body, [])
        start = position(bodies[way.body].pose)
        if own and own[-1].start == way.start:
            findings.report(
                "E0516",
                way.span,
                f"`{way.body}` cannot start two courses at once, at {way.start:g} s",
                help="let one start later: it ends the other",
                labels=[(own[-1].span, "the other one")],
            )
            continue
        own.append(_placed(way, centre_at(start, own, way.start)))
    return tuple(c for own in found.values() for c in own)


def _placed(way: Way, begin: ir.Vec3) -> ir.Course:
    points = tuple((begin[0] + x, begin[1] + y, begin[2] + z) for x, y, z in way.steps)
    return ir.Course(way.body, way.start, points, way.speed, way.returns, way.span)


def breakdowns(findings: Findings, found: Sequence[ir.Breakdown]) -> tuple[ir.Breakdown, ...]:
    """All breakdowns by time. Reports those of a module that failed in the same way, or left the scene, before."""
    kept: list[ir.Breakdown] = []
    for breakdown in sorted(found, key=lambda b: b.time):
        ends = (breakdown.kind, ir.BreakdownKind.GONE)
        before = next((b for b in kept if b.module == breakdown.module and b.kind in ends), None)
        if before is None:
            kept.append(breakdown)
            continue
        findings.report(
            "E0517",
            breakdown.span,
            f"`{breakdown.module}` is {before.kind} already, from {before.time:g} s on",
            labels=[(before.span, "said here")],
        )
    return tuple(kept)
