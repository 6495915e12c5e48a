"""Solves for one run: their settings and counters, and motion between switches, which are drawn anew where phases
find no path."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field, replace

from ....compiler.ir import Problem
from ....langs.counting import counted
from ...budget import Budget, Clock
from ...geometry.attachments import looped
from ...plan import BoundRecord
from ...seeds import Seed
from ...skeleton import LOADS, Bound, BoundResult, Breach, Configuration, Skeleton, beginning
from ..motion.keyframes.initial_guesses import guess
from ..motion.keyframes.local_repair import MENDS, QUICK_MENDS, Mend, mended, resampled, unmoved
from ..motion.keyframes.settings import KEYFRAMES
from ..motion.path.whole_path import solve_path
from ..motion.settings import MotionSettings
from ..schedule.shorter_ways import with_shorter_ways
from ..statics import asked, borne, slowed
from .movable_obstacles import obstacles
from .phase_by_phase import PhasesRequest
from .requests import AttemptRequest, PathRequest, SequenceRequest, sequence_path
from .settings import BOUNDS
from .speculation import Speculation
from .verdicts import Conflict, Judgement, blame, with_motion


@dataclass(eq=False)
class Solves:
    """Single solves, told and counted, and motion for the first phases of a skeleton. `finest` is the last bound that
    is asked, `tries` how many starts a span gets at most."""

    problem: Problem
    settings: MotionSettings
    finest: Bound
    seed: Seed
    budget: Budget
    tell: Callable[[str, str], None]
    ahead: Speculation = field(default_factory=Speculation)
    clock: Clock = field(default_factory=Clock, init=False)
    tries: int | None = field(default=BOUNDS.quick_starts, init=False)
    brief_redraws: bool = field(default=False, init=False)
    """Whether motion that is refused is soon given up at first, as what came before can be changed."""
    cut: Conflict | None = field(default=None, init=False)
    """Of a candidate whose motion is being looked for: what was in the way of the last one, should time run out."""
    _counts: dict[Bound, list[int]] = field(init=False)

    def __post_init__(self) -> None:
        self._counts = {Bound.SEQ: [0, 0], Bound.SEQ_PATH: [0, 0], Bound.PATH: [0, 0]}

    def records(self) -> list[BoundRecord]:
        return [BoundRecord(bound, solved, refused) for bound, (solved, refused) in self._counts.items()]

    def _sequence(
        self, skeleton: Skeleton, seed: Seed, warm: Sequence[Configuration] | None, tries: int | None
    ) -> BoundResult:
        self.tell("seq", f"P_seq of {counted(len(skeleton), 'action')}")
        with self.clock("seq"):
            question = SequenceRequest(self.settings, seed, tries, warm)
            result = self.ahead.answer(skeleton, question, self.budget)
        self._count(Bound.SEQ, result.feasible)
        return result

    def motion(
        self, skeleton: Skeleton, sequence: BoundResult, motions: int | None = None, soon: bool = False
    ) -> Judgement:
        """P_seqPath of the first phases (default: of all) between switch poses, drawn anew, in long skeletons first
        around phases that fail; then P_path. The phases behind them keep a say in where switches are. A refusal by
        P_seq stays one, without conflicts. With `soon` what fails is drawn anew as seldom as where something is in the
        way that could be moved."""
        if not sequence.feasible:
            return Judgement(False)
        first = beginning(skeleton, len(skeleton) if motions is None else motions)
        if not first.phases:
            return Judgement(True, paths=[])
        shorter = self._shortened(skeleton, sequence, first)
        if shorter is not None:
            return shorter
        widest = BOUNDS.first_sampled if self._is_long(first) else math.inf
        result = self._sequence_path(first, sequence, thorough=False, sampled_to=widest)
        blamed = [{v.phase for v in result.violations}]
        if not result.feasible:
            self.cut = blame(Bound.SEQ_PATH, result, blamed, len(first))
        before, (phase, movable) = result, self._obstacles(first, sequence, result, widest)
        sequence, result = self._redrawn(skeleton, first, sequence, result, blamed, soon or bool(movable))
        if result.feasible:
            self.cut = None
            return self._timed(first, result, sequence.configurations[len(first) + 1 :])
        if movable and (result is before or self._obstacles(first, sequence, result, widest) == (phase, movable)):
            told = tuple(v for v in result.violations if v.phase == phase)
            return Judgement(False, conflicts=[Conflict(Bound.SEQ_PATH, 0, phase, True, told, obstacles=movable)])
        bound = Bound.SEQ_PATH
        if self.finest == Bound.PATH and not self._briefly and not all(v.kind in LOADS for v in result.violations):
            known = sequence.configurations[: len(first) + 1]
            free = self._path(first, replace(sequence, configurations=known))
            if free.feasible:
                return self._timed(first, free, [])
            bound = Bound.PATH
        return Judgement(False, conflicts=[blame(bound, result, blamed, len(first))])

    def _obstacles(
        self, first: Skeleton, sequence: BoundResult, result: BoundResult, sampled_to: float
    ) -> tuple[int, frozenset[str]]:
        """What keeps a motion from being found that could be moved away, as long as such candidates come first."""
        if result.feasible or self.tries is None:
            return 0, frozenset()
        return obstacles(first, sequence, result, self.settings, self.seed, self.budget, sampled_to)

    def _redrawn(
        self, skeleton: Skeleton, first: Skeleton, sequence: BoundResult, result: BoundResult, blamed: list[set[int]],
        soon: bool = False,
    ) -> tuple[BoundResult, BoundResult]:  # fmt: skip
        """The switches of a skeleton and the motion of its `first` phases between them, drawn anew until they have one,
        once only and without much effort where it is to be refused `soon`; `blamed` is told which phases had
        none. Several phases are looked at one after the other first. Raises OutOfTime."""
        if not (soon or result.feasible) and self._goes_by_phases(first, result):
            whole = self._unmoved(skeleton, first, sequence, result) if len(first) <= BOUNDS.whole_to else None
            found = whole or self._by_phases(skeleton, sequence, len(first))
            if found is not None:
                return found
        held: set[frozenset[int]] = set()
        mends = MENDS if len(skeleton) > KEYFRAMES.longest_whole else ()
        (quick, draws), loaded = (0, BOUNDS.soon_redraws) if soon else self._draws(first), 0
        for draw in (*mends, *range(1, draws + 1)):
            loaded += bool(result.violations) and all(v.kind in LOADS for v in result.violations)
            if result.feasible or loaded > BOUNDS.loaded_redraws:
                break
            path: BoundResult | None = None
            if isinstance(draw, Mend):
                again = self._mended(skeleton, sequence, result, draw)
            else:
                failed = frozenset(v.phase for v in result.violations)
                still = draw == 1 or (failed not in held and self._closes_a_loop(skeleton, failed))
                held.add(failed)
                again, path = self._attempt(skeleton, sequence, result, draw, len(first), still, draw > quick)
            if not again.feasible:
                continue
            sequence = again
            if path is None:
                if isinstance(draw, int) and draw < draws:
                    self._expect_attempt(skeleton, sequence, result, draw + 1, len(first), draw >= quick)
                before = result if isinstance(draw, Mend) else None
                seed = self.seed if isinstance(draw, Mend) else self.seed.child("attempt", draw)
                quickly = soon or (draw in QUICK_MENDS if isinstance(draw, Mend) else draw <= quick)
                path = self._sequence_path(first, sequence, not quickly, before, seed)
            result = path
            if draw == quick + BOUNDS.long_way_after and not soon and self._may_be_long(first, result):
                result = self._long_way(first, sequence, result)
            blamed.append({v.phase for v in result.violations})
            self.cut = blame(Bound.SEQ_PATH, result, blamed, len(first))
        return sequence, result

    def _may_be_long(self, first: Skeleton, refused: BoundResult) -> bool:
        """Whether all that is wrong is one phase in which something is in the way, and its way may be a long one."""
        failed = {v.phase for v in refused.violations}
        blocked = all(v.kind in (Breach.COLLISION, Breach.SELF_COLLISION) for v in refused.violations)
        alone = len(failed) == 1 and blocked and not self._closes_a_loop(first, failed)
        return alone and self.settings.slices < BOUNDS.long_way_slices and not self._briefly

    def _long_way(self, first: Skeleton, sequence: BoundResult, refused: BoundResult) -> BoundResult:
        """Motion in more slices, with which trees grow for longer: through mazes. What was refused stays so where there
        is none."""
        finer = replace(self.settings, slices=BOUNDS.long_way_slices)
        found = self._sequence_path(first, sequence, thorough=True, settings=finer)
        return found if found.feasible else refused

    def _shortened(self, skeleton: Skeleton, sequence: BoundResult, first: Skeleton) -> Judgement | None:
        """Motion of the first phases between switches that were moved for the sake of the objective; None where these
        are not better, or have no motion between them."""
        if not self.settings.brief:
            return None
        self.tell("seq", f"shorter ways for {counted(len(skeleton), 'action')}")
        with self.clock("seq"):
            found = with_shorter_ways(skeleton, sequence, self.settings, self.seed, self.budget)
        if found is None:
            return None
        result = self._sequence_path(first, found, thorough=False)
        if not result.feasible:
            return None
        judgement = self._timed(first, result, found.configurations[len(first) + 1 :])
        return judgement if judgement.accepted else None

    def _timed(self, skeleton: Skeleton, result: BoundResult, ahead: list[Configuration]) -> Judgement:
        """Accepted, with motions that begin and end gently and are as slow as their drives need."""
        judgement = with_motion(self.problem.world, result, ahead)
        paths, heavy = slowed(skeleton, judgement.paths or [], result.configurations[0])
        if heavy:
            return Judgement(False, conflicts=[Conflict(Bound.SEQ_PATH, 0, heavy[0].phase, True, tuple(heavy))])
        judgement.paths = paths
        return judgement

    def _goes_by_phases(self, first: Skeleton, refused: BoundResult) -> bool:
        """Whether motion of a skeleton is to be found phase by phase."""
        return self._is_long(first) and not all(v.kind in LOADS for v in refused.violations)

    def _is_long(self, first: Skeleton) -> bool:
        """Whether a skeleton is one whose phases may be looked at one after the other."""
        several = BOUNDS.by_phases_from <= len(first) <= BOUNDS.by_phases_to
        return several and not self._closes_a_loop(first, range(len(first)))

    def _unmoved(
        self, skeleton: Skeleton, first: Skeleton, sequence: BoundResult, refused: BoundResult
    ) -> tuple[BoundResult, BoundResult] | None:
        """Switches that move little in the phases that were refused, and the motion of the first phases, if it is found
        with little effort."""
        again, path = self._attempt(skeleton, sequence, refused, 1, len(first), True, False)
        if not again.feasible:
            return None
        if path is None:
            draw = self.seed.child("attempt", 1)
            path = self._sequence_path(first, again, thorough=False, seed=draw, sampled_to=BOUNDS.sampled_width)
        return (again, path) if path.feasible else None

    def _by_phases(
        self, skeleton: Skeleton, sequence: BoundResult, motions: int
    ) -> tuple[BoundResult, BoundResult] | None:
        """The switches and the motion of the first phases, one after the other."""
        self.tell("seq-path", f"{counted(motions, 'phase')}, one after the other")
        with self.clock("seq_path"):
            question = PhasesRequest(self.settings, self.seed, self.tries, motions)
            known, path = self.ahead.answer(skeleton, question, self.budget)
        self._count(Bound.SEQ_PATH, path is not None)
        return None if path is None else (replace(sequence, configurations=known), path)

    def _mended(self, skeleton: Skeleton, sequence: BoundResult, refused: BoundResult, mend: Mend) -> BoundResult:
        """P_seq around the phases that have no path; the other switch poses stay."""
        self.tell("seq", f"P_seq around {counted(len(refused.violations), 'action')}")
        with self.clock("seq"):
            result = mended(skeleton, sequence, refused, mend, self.settings, self.seed, self.budget, self.tries)
        self._count(Bound.SEQ, result.feasible)
        return result

    def _draws(self, first: Skeleton) -> tuple[int, int]:
        """How often the switches of a skeleton, of which `first` is to get its motion, are drawn anew: at first without
        a look for a way among samples, and in all."""
        if self._closes_a_loop(first, range(len(first))):
            return BOUNDS.quick_redraws, BOUNDS.quick_redraws + BOUNDS.redraws
        if self._briefly:
            return 0, BOUNDS.redraws
        return 0, max(BOUNDS.redraws, BOUNDS.redrawn_phases // len(first))

    @property
    def _briefly(self) -> bool:
        """Whether motion is given up soon now: not once bounds try harder."""
        return self.brief_redraws and self.tries is not None

    def _closes_a_loop(self, skeleton: Skeleton, phases: Collection[int]) -> bool:
        return any(looped(self.problem, skeleton.phases[phase].mode) for phase in phases)

    def _drawn(
        self, skeleton: Skeleton, sequence: BoundResult, refused: BoundResult, attempt: int, motions: int, still: bool,
        thorough: bool,
    ) -> AttemptRequest:  # fmt: skip
        """The attempt after P_seqPath between the switch poses of `sequence` was refused: the phases that were refused
        are to move little (`still`: at first, and where others that close a loop were refused), else their switches are
        shaken. Where a loop has no way from posture to posture, all are drawn from anywhere every other time: shaken
        ones come back to where they were."""
        failed = sorted({v.phase for v in refused.violations})
        draw = self.seed.child("attempt", attempt)
        if still:
            warm = unmoved(sequence.configurations, failed)[1:]
        elif attempt % 2 == 0 and self._closes_a_loop(skeleton, failed):
            random, start = draw.child("start").random(), sequence.configurations[0]
            warm = guess(skeleton, range(len(skeleton)), start, random, KEYFRAMES.noise, wide=True)
        else:
            warm = resampled(sequence.configurations, failed, draw.child("start"))[1:]
        return AttemptRequest(self.settings, draw, self.tries, warm, motions, thorough)

    def _attempt(
        self, skeleton: Skeleton, sequence: BoundResult, refused: BoundResult, attempt: int, motions: int, still: bool,
        thorough: bool,
    ) -> tuple[BoundResult, BoundResult | None]:  # fmt: skip
        """P_seq once more, and P_seqPath too where another process has come to it already."""
        if len(skeleton) > KEYFRAMES.longest_whole:
            return self._sequence(skeleton, self.seed.child("attempt", attempt), None, tries=self.tries), None
        drawn = self._drawn(skeleton, sequence, refused, attempt, motions, still, thorough)
        if not self.ahead.expects(skeleton, drawn):
            return self._sequence(skeleton, drawn.draw, drawn.warm, tries=self.tries), None
        self.tell("seq-path", f"P_seqPath of {counted(len(skeleton), 'phase')}")
        with self.clock("seq_path"):
            again, path = self.ahead.answer(skeleton, drawn, self.budget)
        self._count(Bound.SEQ, again.feasible)
        if path is not None:
            self._count(Bound.SEQ_PATH, path.feasible)
        return again, path

    def _expect_attempt(
        self, skeleton: Skeleton, sequence: BoundResult, refused: BoundResult, attempt: int, motions: int,
        thorough: bool,
    ) -> None:  # fmt: skip
        """An attempt, if the same phases are refused as before."""
        if self.ahead.helps and len(skeleton) <= KEYFRAMES.longest_whole:
            drawn = self._drawn(skeleton, sequence, refused, attempt, motions, False, thorough)
            self.ahead.expect(skeleton, drawn, self.budget)

    def _path(self, skeleton: Skeleton, sequence: BoundResult) -> BoundResult:
        """P_path, with bounded effort."""
        self.tell("path", f"P_path of {counted(len(skeleton), 'action')}")
        with self.clock("path"):
            bears = asked(skeleton.problem)
            effort = BOUNDS.path_effort
            result = solve_path(skeleton, self.settings, self.seed, self.budget, sequence, effort=effort, bears=bears)
            result = borne(skeleton, result)
        self._count(Bound.PATH, result.feasible)
        return result

    def _sequence_path(
        self, skeleton: Skeleton, sequence: BoundResult, thorough: bool, known: BoundResult | None = None,
        seed: Seed | None = None, sampled_to: float = math.inf, settings: MotionSettings | None = None,
    ) -> BoundResult:  # fmt: skip
        """P_seqPath of a skeleton, or of a beginning of that of `sequence`."""
        self.tell("seq-path", f"P_seqPath of {counted(len(skeleton), 'phase')}")
        with self.clock("seq_path"):
            draw = seed or self.seed
            if known is None:
                question = PathRequest(settings or self.settings, draw, thorough, sequence, sampled_to)
                result = self.ahead.answer(skeleton, question, self.budget)
            else:
                result = sequence_path(skeleton, sequence, self.settings, draw, self.budget, thorough, known)
        self._count(Bound.SEQ_PATH, result.feasible)
        return result

    def _count(self, bound: Bound, feasible: bool) -> None:
        self._counts[bound][0 if feasible else 1] += 1
