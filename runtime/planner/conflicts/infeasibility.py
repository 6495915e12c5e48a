"""What was refused and why: the records for report and plan, and the explanation for a task that found no plan."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

from ....compiler.ir import Action, Fact, Problem, effects_of, span_of
from ....langs.counting import counted
from ....langs.diagnostics import Diagnostic, Label
from ....langs.source import Span
from ...budget import Status, unless_spent
from ...geometry.attachments import carrier, next_mode
from ...geometry.drives import braked
from ...plan import RefusalRecord, VerdictRecord
from ...skeleton import Bound, Breach, NearestMiss, Skeleton, Violation
from ..bounds.verdicts import Conflict
from ..motion.keyframes.causes import Cause, Why
from ..motion.nlp.program import DIVERGED
from ..plan_assembly import placed
from .lifting import objects_of
from .misses import lack_of, miss_of
from .nearest_miss import nearest
from .settings import CONFLICTS
from .shortfall import achievers, lacking

UNREACHABLE = "no sequence of actions reaches the goal: every state that can be reached was seen"


class Refusals:
    """Collects conflicts in the order in which they were found."""

    def __init__(
        self, problem: Problem, cause: Callable[[Skeleton, Conflict], Cause | None] | None = None
    ) -> None:  # fmt: skip
        """`cause` may say more of a conflict than its violations do."""
        self.problem, self._cause_of = problem, cause
        self._found: list[tuple[Skeleton, Conflict]] = []
        self.misses: list[NearestMiss] = []
        """What can be drawn of what was explained last."""

    def add(self, skeleton: Skeleton, conflict: Conflict) -> None:
        self._found.append((skeleton, conflict))

    def records(self) -> list[RefusalRecord]:
        return [self._record(skeleton, conflict) for skeleton, conflict in self._found]

    def explain(self, status: Status) -> list[Diagnostic]:
        """S-diagnostics: what ended the run, where that was not the last candidate, then the refusals."""
        self.misses = []
        if status == Status.INFEASIBLE:
            return unless_spent(self._unreachable) or [Diagnostic("S0001", UNREACHABLE)]
        if not self._found:
            if status in ENDINGS:
                return [ended(status, "before a sequence of actions was judged")]
            return [Diagnostic("S0002", "no sequence of actions was found that is not expected to be refused")]
        if status not in ENDINGS:
            return self.most_telling()
        return [ended(status, f"after {counted(len(self._found), 'refusal')}"), *self.most_telling()]

    def most_telling(self) -> list[Diagnostic]:
        """The refusals: those of the fewest actions first, then those that were met most often, then the smallest miss;
        one for each row of the program, and with whom it was met."""
        self.misses = []
        groups: dict[object, list[tuple[Skeleton, Conflict]]] = {}
        for skeleton, conflict in self._found:
            groups.setdefault(self._cause(skeleton, conflict), []).append((skeleton, conflict))
        ranked = sorted(groups.values(), key=lambda g: (min(map(_length, g)), -len(g)))
        told: dict[object, Diagnostic] = {}
        left = sum(map(len, ranked))
        for group in ranked[: 2 * CONFLICTS.most_explained]:
            if len(told) == CONFLICTS.most_explained:
                break
            skeleton, conflict = min(group, key=_miss)
            cause = self._looked_into(skeleton, conflict)
            if cause is not None:
                conflict = replace(conflict, violations=(cause.missed,))
            missed = [(v.kind, v.names) for v in conflict.violations[:1]]
            same = str(skeleton.phases[conflict.last].action), conflict.bound, *missed
            if same not in told:
                told[same] = self._diagnostic(skeleton, conflict, cause, len(group))
            left -= len(group)
        return _with_rest([*told.values()], left)

    def _cause(self, skeleton: Skeleton, conflict: Conflict) -> object:
        """What refusals must share to be told as one: rules, bound, and the row or the kind of limit that is missed."""
        rules = tuple(p.action.rule for p in skeleton.phases[conflict.first : conflict.last + 1])
        if not conflict.violations:
            return rules, conflict.bound
        worst = conflict.violations[0]
        return rules, conflict.bound, worst.span or (worst.names[0] if worst.kind == Breach.ROW else worst.kind)

    def _unreachable(self) -> list[Diagnostic]:
        """What the proof says, at the rules that achieve the goal and at the bounds on length that they need."""
        rules = achievers(self.problem)
        names = " or ".join(f"`{rule.name}`" for rule, _ in rules)
        blamed = f"; what achieves it is {names}, never applicable where it would help" if rules else ""
        bounds = [(rule, bound.span) for rule, bound in rules if bound is not None and bound.span is not None]
        goal, achieving = span_of(self.problem.goal), rules[0][0].span if rules else None
        labels = [Label(achieving, "a rule that achieves it")] if goal and achieving else []
        labels += [Label(span, f"a bound that `{rule.name}` needs") for rule, span in bounds]
        found = lacking(self.problem)[:CONFLICTS.most_explained]
        message, lacks = f"{UNREACHABLE}{blamed}", [*map(str, found)]
        self.misses = [lack_of(self.problem, message, lack) for lack in found]
        if not lacks:
            near = nearest(self.problem, [rule for rule, _ in rules])
            lacks = [str(near)] if near else [""]
            labels += [Label(near.place, "this stays false")] if near and near.place else []
        return [
            Diagnostic(
                "S0001",
                message,
                goal or achieving,
                tuple(labels),
                note=lack or None,
                help="look at the conditions of the rules that achieve the goal, and at the reach of the robots",
            )
            for lack in lacks
        ]

    def _diagnostic(self, skeleton: Skeleton, conflict: Conflict, cause: Cause | None, count: int) -> Diagnostic:
        action = skeleton.phases[conflict.last].action
        rule = self.problem.rules.get(action.rule)
        where = " from the start" if conflict.from_start and conflict.first < conflict.last else ""
        span = self._span(conflict)
        labels = [Label(rule.span, "the rule of this action")] if rule is not None and rule.span else []
        if cause is not None and cause.why == Why.REACH:
            labels += self._put(action)
        earlier = ", ".join(str(p.action) for p in skeleton.phases[conflict.first : conflict.last])
        notes = [f"straight after {earlier}{where}"] if earlier else []
        notes += [*self._still(skeleton, conflict), *self._lasting(skeleton, conflict)]
        if cause is not None and cause.names and cause.why in (Why.CONTRADICTED, Why.HELD, Why.REACH):
            notes += self._held_since(skeleton, conflict.last, cause.names)
        if conflict.obstacles:
            seq = conflict.bound == Bound.SEQ
            where = "there it can be done" if seq else "at the place of the start there is a motion"
            notes.append(f"without {', '.join(sorted(conflict.obstacles))} {where}")
        if count > 1:
            of = "" if _goes_on(skeleton, conflict) else " of those at the end of a plan"
            notes.append(f"this was met in {count} such sequences; the smallest miss{of} is shown")
        row = f"{self._reason(conflict)}{told(cause)}"
        message = f"{_BOUND_NAMES[conflict.bound]} refuses {action}: {row}"
        miss = miss_of(self.problem, str(action), message, row, conflict, cause)
        self.misses += [] if miss is None else [miss]
        return Diagnostic(
            "S0002",
            message,
            span or (rule.span if rule else None),
            tuple(labels) if span else (),
            note="; ".join(notes) or None,
        )

    def _put(self, action: Action) -> list[Label]:
        """Where the scene puts the bodies that an action is about."""
        bodies = [self.problem.world.bodies[n] for n in objects_of(action) if n in self.problem.world.bodies]
        return [Label(body.span, f"`{body.name}` is put here") for body in bodies if body.span is not None]

    def _looked_into(self, skeleton: Skeleton, conflict: Conflict) -> Cause | None:
        """The cause of a conflict, where there is time left to look for it."""
        asked = self._cause_of
        return None if asked is None else unless_spent(lambda: asked(skeleton, conflict))

    def _still(self, skeleton: Skeleton, conflict: Conflict) -> list[str]:
        """What a row that is missed asks of modules whose joints have no drive and are held by their brakes."""
        if not conflict.violations or conflict.violations[0].kind != Breach.ROW:
            return []
        worst = conflict.violations[0]
        held = braked(self.problem, skeleton.phases[worst.phase].mode)
        told = []
        for name in dict.fromkeys(carrier(self.problem, n) for n in worst.names[1:]):
            joints = [self.problem.world.modules[name].type.joints[i].name for i in sorted(held.get(name, ()))]
            if joints:
                told.append(f"{', '.join(joints)} of {name} cannot move: no drive, and nothing with drives holds it")
        return told

    def _lasting(self, skeleton: Skeleton, conflict: Conflict) -> list[str]:
        """Of a literal that holds from an action before: that no rule deletes it, or that what does so comes too late,
        at the end of its own motion."""
        if not conflict.violations or conflict.violations[0].kind != Breach.ROW:
            return []
        worst = conflict.violations[0]
        told = self._held_since(skeleton, worst.phase, worst.names)
        return [] if worst.names in next_mode(skeleton, worst.phase) and self._deleted(worst.names) else told

    def _held_since(self, skeleton: Skeleton, at: int, literal: Fact) -> list[str]:
        """Of a literal that holds in phase `at`, where it holds: since when, and what would end it in time."""
        phases = skeleton.phases
        if literal not in phases[at].mode:
            return []
        since = next((p.action for p in phases[at::-1] if literal in p.added), None)
        holds = f"[{' '.join(literal)}] holds since {since or 'the start'}"
        if not self._deleted(literal):
            end = f"unless an action has the effect `not [{literal[0]} …]`"
            return [f"{holds}, and no rule deletes it: its rows bind to the end, {end}"]
        if literal in next_mode(skeleton, at):
            return [f"{holds} and after {phases[at].action} still: an action would have to delete it before"]
        return [f"{holds} until the switch of {phases[at].action}: an action of its own would have to delete it before"]

    def _deleted(self, literal: Fact) -> bool:
        """Whether some rule deletes literals of this predicate."""
        effects = [e for r in self.problem.rules.values() for e in effects_of(r.effects)]
        return any(e.negated and e.literal.predicate == literal[0] for e in effects)

    def _reason(self, conflict: Conflict) -> str:
        if not conflict.violations:
            return "no motion was found"
        return describe(conflict.violations[0])

    def _span(self, conflict: Conflict) -> Span | None:
        for violation in conflict.violations[:1]:
            if violation.span is not None:
                return violation.span
            if violation.kind == Breach.ROW:
                return self.problem.motions[violation.names[0]].span
        return None

    def _record(self, skeleton: Skeleton, conflict: Conflict) -> RefusalRecord:
        worst = conflict.violations[0] if conflict.violations else None
        span = self._span(conflict)
        return RefusalRecord(
            bound=conflict.bound,
            actions=[str(p.action) for p in skeleton.phases[conflict.first : conflict.last + 1]],
            reason=self._reason(conflict),
            amount=float(worst.amount) if worst else 0.0,
            unit=worst.unit if worst else "",
            place=placed(self.problem, span),
        )


def _with_rest(told: list[Diagnostic], more: int) -> list[Diagnostic]:
    """Diagnostics that end by how many refusals are not told."""
    if told and more:
        told[-1] = replace(told[-1], note="; ".join(filter(None, (told[-1].note, counted(more, "more refusal")))))
    return told


def distrust(verdict: VerdictRecord | None) -> list[Diagnostic]:
    """What the verifier says against a plan, the first few things."""
    failures = [] if verdict is None else verdict.failures
    most = CONFLICTS.most_explained
    told = [Diagnostic("S0004", f"the verifier refuses the plan: {f.message}") for f in failures[:most]]
    if len(failures) > most:
        told[-1] = replace(told[-1], note=f"and {len(failures) - most} more failures")
    return told


def unverified() -> Diagnostic:
    """Says that there was no time, or memory, for the verifier."""
    help = "give more with --time; --keep-refused FILE keeps the plan, for `tamplang verify FILE`"
    return Diagnostic("S0011", "time or memory were spent before the plan was verified", help=help)


def fewer(status: Status, found: int, wanted: int) -> Diagnostic:
    """Says that a run ended with fewer plans than were asked for."""
    return ended(status, f"after {found} of {counted(wanted, 'plan')}")


def wider(status: Status, gap: float, wanted: float, unit: str) -> Diagnostic:
    """Says that a run ended with a gap that is wider than was asked for."""
    return ended(status, f"with a gap of {gap:.3g} instead of {wanted:.3g} {unit}".rstrip())


ENDINGS = {
    Status.BUDGET: ("S0003", "the budget ended", "give more with --time or --nodes, or a smaller instance"),
    Status.MEMORY: ("S0010", "the memory was spent", "give more with --memory, or a smaller instance"),
    Status.INTERRUPTED: ("S0005", "the run was interrupted", None),
}
"""Code, words and help for each status of a run that was ended from outside."""


def ended(status: Status, where: str) -> Diagnostic:
    """Says what ended a run, and `where` it stood then."""
    code, reason, help = ENDINGS.get(status, ("S0002", "no further sequence of actions passed", None))
    return Diagnostic(code, f"{reason} {where}", help=help)


def _length(item: tuple[Skeleton, Conflict]) -> int:
    return item[1].last - item[1].first


def _miss(item: tuple[Skeleton, Conflict]) -> tuple[int, bool, float]:
    """Of refusals that are told as one the most telling one is least: what would have reached the goal blocks all ways
    there, where what comes before may have another way."""
    skeleton, conflict = item
    worst = max((v.amount for v in conflict.violations), default=float("inf"))
    return _length(item), _goes_on(skeleton, conflict), worst


def _goes_on(skeleton: Skeleton, conflict: Conflict) -> bool:
    """Whether the plan goes on behind what was refused."""
    return conflict.last < len(skeleton) - 1


_BOUND_NAMES = {
    Bound.STATICS: "the weight", Bound.SEQ: "P_seq", Bound.SEQ_PATH: "P_seqPath", Bound.PATH: "P_path",
}  # fmt: skip
_TOLD = {
    Breach.ROW: "[{0}] is missed",
    Breach.COLLISION: "{1} and {2} would overlap",
    Breach.SELF_COLLISION: "parts of {1} would overlap",
    Breach.JOINT_LIMIT: "a joint limit of {1} is exceeded",
    Breach.STEP: "joint {2} of {1} moves too far between two slices",
    Breach.DRIFT: "what rests would slip",
    Breach.UNIT_QUATERNION: "an orientation is missed",
    Breach.TORQUE: "the drive of joint {2} of {1} is too weak",
    Breach.BEARING: "joint {2} of {1} is bent too hard across its axis",
    Breach.DOCK: "{1} and {2} do not hold together",
    Breach.FOOT: "{1} and {2} do not stay together",
    Breach.SLIP: "{2} would slip on {1}",
    Breach.TIP: "{2} would tip over on {1}",
}


def describe(violation: Violation) -> str:
    """One clause for a violated row: `[touch c.B item] is missed by 0.213 m`."""
    if violation.kind in (Breach.COLLISION, Breach.SELF_COLLISION) and violation.amount < DIVERGED:
        return _apart(violation)
    text = _TOLD[violation.kind].format(" ".join(violation.names), *violation.names)
    if violation.amount >= DIVERGED:
        who = f"[{' '.join(violation.names)}]" if violation.kind == Breach.ROW else f"the {violation.kind}"
        return f"the numbers of {who} diverge"
    unit = "" if violation.unit == "1" else f" {violation.unit}"
    if violation.load is not None:
        borne, safety, strength = violation.load
        kept = "" if safety * borne > strength else "what is kept for between instants of "
        more = f"{safety:g} times, is more than {kept}{strength:.3g}{unit}"
        share = " of what its edge bears" if violation.kind == Breach.TIP else " of what friction bears"
        return f"{text}: {borne:.3g}{unit or share} {violation.when}, {more}"
    return f"{text} by {violation.amount:.3g}{unit}"


def told(cause: Cause | None) -> str:
    """A clause that says what a miss comes from: `; out of reach, even with nothing in the way`."""
    if cause is None:
        return ""
    if cause.why == Why.REACH:
        missed = "out of reach" if cause.missed.unit == "m" else "no posture comes nearer"
        return f": {missed}, even with nothing in the way"
    if cause.why == Why.HELD:
        return f": [{' '.join(cause.names)}] keeps what would have to move where it is"
    if cause.why == Why.CONTRADICTED:
        return f": [{' '.join(cause.names)}] does not go with it"
    if cause.why == Why.RING:
        verb = "are" if len(cause.names) > 1 else "is"
        return f": the ring that {', '.join(cause.names)} {verb} held in cannot close farther than that"
    if cause.why == Why.LIMIT:
        return f": {' and '.join(map(_beyond, cause.at[:CONFLICTS.joints_named]))} past the limit"
    return f", else {_apart(cause.at[0])}"


def _beyond(violation: Violation) -> str:
    """How far a joint would have to go."""
    module, joint = violation.names
    amount = _length_of(violation.amount) if violation.unit == "m" else f"{math.degrees(violation.amount):.3g} deg"
    return f"joint {joint} of {module} would have to go {amount}"


def _apart(violation: Violation) -> str:
    """Of two parts, how deep they would overlap, or how near they come where more was wished for."""
    one, other = violation.parts or violation.names
    distance = violation.asked - violation.amount
    if distance > 0.0:
        return f"{one} comes within {_length_of(distance)} of {other}, {_length_of(violation.asked)} wished for"
    return f"{one} and {other} would overlap by {_length_of(-distance)}"


def _length_of(metres: float) -> str:
    """A length as it is read: in millimetres below 10 cm."""
    return f"{1e3 * metres:.3g} mm" if metres < 0.1 else f"{metres:.3g} m"
