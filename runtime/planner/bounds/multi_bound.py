"""Multi-bound judgement of one skeleton (thesis, section 3.2): cheap bounds first, conflicts when one refuses."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace

from ....compiler.ir import Action, Problem
from ....compiler.objectives import ACTIONS
from ....langs.counting import counted
from ...budget import Budget, unless_spent
from ...geometry.attachments import followers
from ...plan import Plan, StatisticsRecord, TimingRecord
from ...seeds import Seed
from ...skeleton import Bound, BoundResult, Configuration, PhasePath, Skeleton, beginning
from ...verify import verify
from ..conflicts.lifting import objects_of
from ..conflicts.nogoods import GeneralisedNoGoods
from ..conflicts.openings import holds_whatever_others_do, opening, taking_part
from ..motion.keyframes.causes import Cause, cause
from ..motion.keyframes.initial_guesses import guess
from ..motion.keyframes.multi_start import judged_alone
from ..motion.keyframes.settings import KEYFRAMES
from ..plan_assembly import assemble
from ..statics import Unbearable, unbearable
from .length_unit import LengthUnit
from .movable_obstacles import bystanders
from .requests import SequenceRequest, WindowRequest
from .settings import BOUNDS
from .solves import Solves
from .verdicts import Conflict, Judgement, missed


class MultiBound(Solves):
    """The bounds of one run, and what single actions were already found to allow."""

    def __post_init__(self) -> None:
        self._use(self.problem)
        super().__post_init__()
        self._windows: dict[tuple[object, ...], BoundResult] = {}
        self._feasible: set[tuple[object, ...]] = set()
        self._left_out = 0
        """How many candidates in a row were only expected to be refused."""
        self.experience = GeneralisedNoGoods(self.problem)

    def restart(self, problem: Problem, seed: Seed, budget: Budget, undoable: bool = False) -> None:
        """Go on with the same task from another state: what was learnt of phases wherever they start stays. Where that
        state is `undoable`, motion from there is soon given up at first."""
        self._use(problem)
        self.brief_redraws = undoable
        self.seed, self.budget = seed, budget
        self.tries = BOUNDS.quick_starts
        self._windows.clear()
        self._feasible.clear()
        self.experience.leave_start()

    def _use(self, problem: Problem) -> None:
        self.scene, self.unit = problem, LengthUnit(problem)
        self.problem = self.unit.problem

    def judge(
        self, skeleton: Skeleton, strains: Sequence[float], motions: int | None = None, brisk: bool = False
    ) -> Judgement:
        """Take a skeleton through the bounds; `strains` tells how close the conditions of each action are to their
        limits (`symbolic.strain`). With `motions` only so many phases get their motion, and P_seq looks farther ahead.
        A `brisk` refusal of what only goes wrong together has no conflicts. Raises OutOfTime."""
        self.ahead.forget()
        self.cut = None
        return self.unit.judgement(self._judged(self.unit.skeleton(skeleton), strains, motions, brisk))

    def cut_short(self) -> Sequence[Conflict]:
        """What was in the way of the candidate during whose judgement time ran out, as far as its motion was asked."""
        return [] if self.cut is None else self.unit.judgement(Judgement(False, conflicts=[self.cut])).conflicts

    def _judged(
        self, skeleton: Skeleton, strains: Sequence[float], motions: int | None, brisk: bool
    ) -> Judgement:
        sure = self.tries is None  # bounds that try harder are the last to be asked: nothing is left out unasked
        expected = [] if sure else self.experience.expected_refusals(skeleton.phases, strains)
        if expected and self._left_out < BOUNDS.left_out:
            self._left_out += 1
            return Judgement(False, conflicts=[Conflict(Bound.EXPECTED, *window, ()) for window in expected])
        if expected:
            self.experience.forget()
        self._left_out = 0
        heavy = unbearable(skeleton)
        conflicts = self._refused_actions(skeleton, strains) if heavy is None else [_too_heavy(heavy)]
        if not conflicts:
            if brisk:
                sequence, end = self._sequence(skeleton, self.seed, None, tries=self.tries), len(skeleton)
            else:
                sequence, end = self._whole(skeleton)
            if sequence.feasible:
                if self.finest == Bound.SEQ:
                    return Judgement(True)
                return self.motion(skeleton, sequence, motions)
            if brisk:
                return Judgement(False)
            conflicts = [self._shrink(skeleton, sequence, end)]
        for c in conflicts:
            window = slice(c.first, c.last + 1)
            if not c.obstacles and not (c.from_start and self.tries is None):
                self.experience.refuse(skeleton.phases[window], strains[window], c.from_start)
        return Judgement(False, conflicts=conflicts)

    def go_on(self, skeleton: Skeleton, motions: int, ahead: Sequence[Configuration]) -> Judgement:
        """As `judge`, for a way that was seen before: `ahead` holds its first switch configurations as they were
        expected then. A refusal has no conflicts. Raises OutOfTime."""
        skeleton, ahead = self.unit.skeleton(skeleton), [self.unit.configuration(c) for c in ahead]
        return self.unit.judgement(self.motion(skeleton, self._onward(skeleton, ahead), motions, self._briefly))

    def _onward(self, skeleton: Skeleton, ahead: Sequence[Configuration]) -> BoundResult:
        """P_seq from the first switch configurations `ahead`, and guesses behind them."""
        random = self.seed.child("onward").random()
        rest = range(len(ahead), len(skeleton))
        warm = [*ahead[: len(skeleton)], *guess(skeleton, rest, ahead[-1], random, KEYFRAMES.noise)]
        return self._sequence(skeleton, self.seed, warm, tries=self.tries)

    def retry(self, skeleton: Skeleton, motions: int) -> Judgement:
        """As `judge`, for a way that was refused only from the start: with all starts, and others than before. A
        refusal has no conflicts. Raises OutOfTime."""
        skeleton = self.unit.skeleton(skeleton)
        sequence = self._sequence(skeleton, self.seed.child("retry"), None, tries=None)
        return self.unit.judgement(self.motion(skeleton, sequence, motions))

    def cause(self, skeleton: Skeleton, conflict: Conflict) -> Cause | None:
        """Why P_seq refuses phases, where these are few enough to look at. Raises OutOfTime."""
        if conflict.bound != Bound.SEQ or conflict.last - conflict.first >= KEYFRAMES.longest_cause:
            return None
        found = cause(
            self.unit.skeleton(skeleton), conflict.first, conflict.last, conflict.first > 0, self.settings, self.seed,
            self.budget.whole, [self.unit.configuration(c) for c in conflict.switches],
        )  # fmt: skip
        return None if found is None else self.unit.cause(found)

    def try_harder(self) -> None:
        """Forget every refusal; from now on each span gets all its starts, and others than before."""
        self.experience.forget()
        self._windows = {key: result for key, result in self._windows.items() if result.feasible}
        self.seed = self.seed.child("harder")
        self.tries = None

    def believe(
        self, skeleton: Skeleton, actions: Sequence[Action], judgement: Judgement, statistics: StatisticsRecord,
        timing: TimingRecord,
    ) -> tuple[Plan, list[PhasePath]]:  # fmt: skip
        """The plan with the verifier's verdict in it, without one where there was no time for it, and its motion. One
        that is refused gets a second motion, with larger margins, from another seed, and between switches that were not
        moved for the sake of the objective: where rows bound what is measured, these may miss it. Raises OutOfTime."""
        plan, paths = self._verified(skeleton, actions, judgement, statistics, timing), judgement.paths or []
        if plan.verdict is None or plan.verdict.verified:
            return plan, paths
        careful, seed = self.settings, self.seed
        try:
            self.settings = replace(careful.wider(BOUNDS.wider_margin), objective=ACTIONS)
            self.seed = seed.child("wider")
            own = self.unit.skeleton(skeleton)
            judgement = self.unit.judgement(self.motion(own, self._sequence(own, self.seed, None, tries=self.tries)))
        finally:
            self.settings, self.seed = careful, seed
        if judgement.paths is None:
            return plan, paths
        again = self._verified(skeleton, actions, judgement, statistics, timing)
        return (again, judgement.paths) if again.verdict is not None and again.verdict.verified else (plan, paths)

    def _verified(
        self, skeleton: Skeleton, actions: Sequence[Action], judgement: Judgement, statistics: StatisticsRecord,
        timing: TimingRecord,
    ) -> Plan:  # fmt: skip
        import msgspec

        statistics = msgspec.structs.replace(
            statistics, path_cost=judgement.path_cost, path_cost_before=judgement.path_cost_before
        )
        self.tell("verify", f"verifying a plan of {counted(len(actions), 'action')}")
        plan = assemble(self.scene, actions, skeleton, judgement.paths or [], statistics)
        with self.clock("verify"):
            verdict = unless_spent(lambda: verify(plan, self.budget.whole))
        return msgspec.structs.replace(plan, verdict=verdict, timing=timing)

    def _refused_actions(self, skeleton: Skeleton, strains: Sequence[float]) -> list[Conflict]:
        """Conflicts of all single actions that P_seq refuses, wherever they start, up to the first with something in
        the way, as that may have led where nothing can be done any more. The most strained go first: those that are
        less so then need no solve."""
        conflicts: list[Conflict] = []
        order = sorted(range(len(skeleton)), key=lambda k: (-strains[k], k))
        end = len(skeleton)
        for number, k in enumerate(order):
            phase = skeleton.phases[k]
            if k > end or self._needs_no_solve(skeleton, strains, k):
                continue
            self._expect_actions(skeleton, strains, order[number + 1 :], whole=not conflicts)
            result = self._window(skeleton, k, k)
            if not result.feasible:
                obstacles = self._bystanders(skeleton, k, result)
                conflicts.append(replace(self._missed(skeleton, result, k, k), obstacles=obstacles))
                end = k if obstacles else end
            elif k:
                self.experience.accept(phase, strains[k])
            else:
                self._feasible.add(self._beginning_key(skeleton, 1))
        return sorted((c for c in conflicts if c.last <= end), key=lambda conflict: conflict.last)

    def _bystanders(self, skeleton: Skeleton, k: int, refused: BoundResult) -> frozenset[str]:
        """The bodies that keep an action from being done though they could be moved: elsewhere they need not, so that
        its refusal is not kept for other states."""
        with self.clock("seq"):
            found = bystanders(skeleton, k, refused, self.settings, self.seed, self.budget)
        if found:
            del self._windows[self._window_key(skeleton, k, k)]
        return found

    def refused_openings(
        self, skeleton: Skeleton, asked: Collection[int], leaving: Sequence[frozenset[str]]
    ) -> Iterator[tuple[int, frozenset[str], Skeleton, Conflict]]:
        """The phases of those `asked` before which nothing that takes part in them has left its place, and that P_seq
        refuses at the start whatever others do; each with what takes part, the skeleton of it alone, and why. `leaving`
        tells what each action has leave its place. Raises OutOfTime."""
        left: frozenset[str] = frozenset()
        for k in range(len(skeleton)):
            movers = taking_part(skeleton, k) if k in asked else None
            if movers is not None and not movers & left:
                alone = opening(skeleton, k)
                result = self.unit.result(self._window(self.unit.skeleton(alone), 0, 0))
                if holds_whatever_others_do(alone, result):
                    yield k, movers, alone, missed(result, 0, 0, True)
            left |= leaving[k]

    def _needs_no_solve(self, skeleton: Skeleton, strains: Sequence[float], k: int) -> bool:
        """Whether an action alone is expected to succeed, or cannot be judged alone."""
        if k == 0:
            return False
        return self.experience.expects_success(skeleton.phases[k], strains[k]) or not judged_alone(skeleton, k)

    def _window(self, skeleton: Skeleton, first: int, last: int) -> BoundResult:
        """P_seq of some phases alone."""
        key = self._window_key(skeleton, first, last)
        if key not in self._windows:
            self.tell("seq", f"P_seq of {skeleton.phases[last].action}")
            with self.clock("seq"):
                result = self.ahead.answer(skeleton, WindowRequest(self.settings, self.seed, first, last), self.budget)
            self._count(Bound.SEQ, result.feasible)
            self._windows[key] = result
        return self._windows[key]

    def _window_key(self, skeleton: Skeleton, first: int, last: int) -> tuple[object, ...]:
        """From the start itself names matter, elsewhere interchangeable ones do not; but it matters what was just taken
        from where it was at the start."""
        phases = skeleton.phases[first : last + 1]
        if not first:
            return tuple(phase.action for phase in phases)
        return *self.experience.lifted(phases), self._begin(skeleton, first, last) < first

    def _missed(self, skeleton: Skeleton, refused: BoundResult, first: int, last: int) -> Conflict:
        """The conflict of phases refused alone; the state before them is also the one before what it begins with."""
        found, begin = missed(refused, first, last, first == 0), self._begin(skeleton, first, last)
        return found if begin == first else replace(found, first=begin, switches=found.switches[:1] + found.switches)

    def _begin(self, skeleton: Skeleton, first: int, last: int) -> int:
        """Where a conflict of phases `first` … `last` begins: one earlier where that action took a thing which has not
        moved since, as the window has it where it was at the start."""
        world, mode = self.problem.world, skeleton.phases[first].mode
        earlier = (followers(self.problem, phase.mode) for phase in skeleton.phases[:first])
        taken = followers(self.problem, mode).difference(*earlier) if first else frozenset()
        movers = {world.owner(n) for phase in skeleton.phases[first : last + 1] for n in objects_of(phase.action)}
        tied = any(taken.intersection(fact) and movers.intersection(map(world.owner, fact[1:])) for fact in mode)
        return first - 1 if tied else first

    def _whole(self, skeleton: Skeleton) -> tuple[BoundResult, int]:
        """P_seq of a skeleton; where it is refused, of the shortest beginning that is, and how long that is. It takes
        long to refuse, the more so what is long: from the phase on that fails after one start of all, beginnings grow
        until one is refused; the whole then begins where the longest of them ends. The windows of a long skeleton tell
        it by themselves, exactly once they came far."""
        known, end = self._known(skeleton), len(skeleton)
        found: BoundResult | None = None
        certain = end > KEYFRAMES.longest_whole
        refused = self._sequence(skeleton, self.seed, None, tries=self.tries if certain else BOUNDS.first_starts)
        if refused.window is not None:
            return refused, refused.window[1] + 1
        if certain and refused.violations:
            worst = refused.violations[0].phase
            far = worst + BOUNDS.conflict_reach > KEYFRAMES.longest_whole
            around = max(0, worst - BOUNDS.conflict_reach), min(end, worst + BOUNDS.conflict_reach)
            known, end = (worst, worst + 1) if far else around
        while not refused.feasible and (end - known > 1 or not certain):
            blamed = refused.violations[0].phase if refused.violations else end - 1
            asked = max(known + 1, min(blamed, end - 1))
            if not certain and known >= min(blamed + BOUNDS.conflict_reach, end - 1):
                asked = end
            self._expect_beginnings(skeleton, asked, end)
            if asked == len(skeleton) and found is not None:
                result = self._onward(skeleton, found.configurations[1:])
            else:
                result = self._sequence(beginning(skeleton, asked), self.seed, None, tries=self.tries)
            if not result.feasible:
                refused, end, certain = result, asked, True
            elif asked == len(skeleton):
                return result, asked
            else:
                known, found = asked, result
                self._feasible |= {self._beginning_key(skeleton, k) for k in range(1, known + 1)}
        return refused, end

    def _known(self, skeleton: Skeleton) -> int:
        """How long a proper beginning is known to be feasible."""
        shorter = range(len(skeleton) - 1, 0, -1)
        return next((k for k in shorter if self._beginning_key(skeleton, k) in self._feasible), 0)

    def _beginning_key(self, skeleton: Skeleton, length: int) -> tuple[object, ...]:
        return self.settings, skeleton.coming, tuple(phase.action for phase in skeleton.phases[:length])

    def _shrink(self, skeleton: Skeleton, refused: BoundResult, end: int) -> Conflict:
        """A minimal contiguous conflict behind a refused P_seq of the first `end` phases: the fewest at their end that
        are refused wherever they start; all from the start where there are none."""
        for first in range(end - 1, max(0, end - BOUNDS.longest_conflict - 1), -1):
            if not judged_alone(skeleton, first):
                continue
            self._expect_windows(skeleton, first, end - 1)
            window = self._window(skeleton, first, end - 1)
            if not window.feasible:
                return self._missed(skeleton, window, first, end - 1)
        if refused.window is None or not refused.window[0]:
            return missed(refused, 0, end - 1, True)
        first, last = refused.window
        while last > first and not (shorter := self._window(skeleton, first, last - 1)).feasible:
            refused, last = shorter, last - 1
        return self._missed(skeleton, refused, first, last)

    # --- what is probably asked next ------------------------------------------------------------------------------

    def _expect_window(self, skeleton: Skeleton, first: int, last: int) -> bool:
        if self._window_key(skeleton, first, last) in self._windows:
            return True
        return self.ahead.expect(skeleton, WindowRequest(self.settings, self.seed, first, last), self.budget)

    def _expect_actions(self, skeleton: Skeleton, strains: Sequence[float], later: Sequence[int], whole: bool) -> None:
        """The other single actions, then the whole skeleton: it comes next when none of them is refused."""
        if not self.ahead.helps:
            return
        for k in later:
            if not self._needs_no_solve(skeleton, strains, k) and not self._expect_window(skeleton, k, k):
                return
        if whole:
            in_one = len(skeleton) <= KEYFRAMES.longest_whole
            self._expect_whole(skeleton, BOUNDS.first_starts if in_one else self.tries)

    def _expect_whole(self, skeleton: Skeleton, tries: int | None) -> bool:
        return self.ahead.expect(skeleton, SequenceRequest(self.settings, self.seed, tries), self.budget)

    def _expect_beginnings(self, skeleton: Skeleton, asked: int, end: int) -> None:
        """The longer beginnings, which are asked about when the one that is `asked` now is feasible."""
        for length in range(asked + 1, end + 1) if self.ahead.helps else ():
            if not self._expect_whole(beginning(skeleton, length), self.tries):
                return

    def _expect_windows(self, skeleton: Skeleton, first: int, last: int) -> None:
        """The next longer windows that end with the same phase."""
        if self.ahead.helps:
            for earlier in range(first - 1, max(0, last - BOUNDS.longest_conflict), -1):
                if judged_alone(skeleton, earlier) and not self._expect_window(skeleton, earlier, last):
                    return


def _too_heavy(found: Unbearable) -> Conflict:
    """An action that no posture bears: refused wherever it starts, or from the start."""
    return Conflict(Bound.STATICS, 0 if found.from_start else found.phase, found.phase, found.from_start, found.told)
