"""The bound P_seqPath: with the switches given, every phase is a point-to-point problem of its own in joint values.

Phases are solved all at once, in batches of equal structure: from a straight start, then from bent and bumped starts,
then from a sampled polyline. A path is accepted only by the swept check on its spline.
"""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence

import numpy as np

from .....compiler.ir import World
from .....compiler.motion.collision import contacts
from ....budget import Budget
from ....seeds import Seed
from ....skeleton import Array, Bound, BoundResult, Breach, Configuration, PhasePath, Skeleton, Violation
from ..path.settings import PATHS
from ..settings import MotionSettings
from ..time_scaling import shortest_duration
from .attempts import PhaseGroup, improve, polish_groups, solve_groups, start_group
from .exact_check import Clash, blocked, worst_clash
from .joint_forest import PhaseTree, UnsupportedPhase, arrive, phase_tree
from .mounted import placed
from .phase_batch import Batch
from .phase_geometry import make_parts
from .settings import PHASES
from .smoothing import path_cost
from .swept_clearance import between
from .warm_starts import cost_of, taken_over


def _blocked(batch: Batch) -> list[Violation]:
    """Phases whose first or last pose is blocked itself."""
    found = []
    for poses in (batch.start, batch.end):
        for k in np.flatnonzero(blocked(batch.exact, poses[:, None])):
            clash = worst_clash(batch.exact, int(k), poses[k][None])
            found.append(_told(int(batch.phases[k]), clash))
    return found


def _told(phase: int, clash: Clash) -> Violation:
    own = clash.pair[0].partition(".")[0] == clash.pair[1].partition(".")[0]
    kind = Breach.SELF_COLLISION if own else Breach.COLLISION
    return Violation(phase, kind, clash.pair, clash.amount, "m", asked=clash.asked, parts=clash.parts)


def _failures(group: PhaseGroup, world: World) -> list[Violation]:
    """What is wrong with the best path of every phase that is not solved: the worst pair, or when nothing is in the
    way, the joint that passes its limit or moves too far between two slices."""
    found = []
    batch = group.batch
    for k in np.flatnonzero(~group.solved):
        phase = int(batch.phases[k])
        values = batch.stored @ group.paths[k]
        for looks in (values[::PHASES.blame_stride], values, between(values)):
            clash = worst_clash(batch.exact, int(k), looks)
            if clash.amount > 0.0:
                break
        if clash.amount > 0.0:
            found.append(_told(phase, clash))
            continue
        joints = batch.joints
        beyond = np.maximum(values - joints.upper[k], joints.lower[k] - values).max(axis=0)
        step = np.abs(np.diff(group.paths[k], axis=0)).max(axis=0) - joints.step[k]
        kind, excess = (Breach.JOINT_LIMIT, beyond) if beyond.max() > PHASES.beyond else (Breach.STEP, step)
        module, joint = batch.variables[k][int(excess.argmax())]
        record = world.modules[module].type.joints[joint]
        found.append(Violation(phase, kind, (module, record.name), float(excess.max()), record.unit))
    return found


def solve_sequence_path(
    skeleton: Skeleton, configurations: Sequence[Configuration], settings: MotionSettings, seed: Seed, budget: Budget,
    thorough: bool = True, known: BoundResult | None = None, sampled_to: float = math.inf,
) -> BoundResult:  # fmt: skip
    """P_seqPath (thesis, section 3.2): motions between the given K + 1 switch configurations, whose switch rows hold
    to 1e-6. Unless `thorough`, hard phases fail soon, as they do where switches can be drawn anew; those of more joints
    than `sampled_to` get no way among samples. Phases that have a path in `known`, a result between other switches or
    of a beginning, keep it where their own two are the same.

    The result's configurations take their joint values from the given ones and their poses from the kinematics of
    the phases before, so that what rests does not drift. When a phase fails, `paths` hold the best attempts and
    `violations` the worst pair of each failed phase; a switch that is blocked itself is reported at once, without
    paths. Phases that are no open chains are solved one by one as motion programs over whole modules. Raises
    OutOfTime.
    """
    started = time.perf_counter()
    trees, states, drift, others = chained(skeleton, configurations, settings)
    kept = taken_over(known, trees, [states[0][0], *(e for _, e in states)])
    groups = grouped(skeleton, [t for t in trees if t.phase not in kept], states, settings)
    result = BoundResult(Bound.SEQ_PATH, False, math.inf, 0.0, 0, [states[0][0], *(e for _, e in states)], [], drift)
    result.violations += [v for group in groups for v in _blocked(group.batch)]
    if not result.violations:
        result.iterations = solve_groups(groups, seed, budget, thorough, sampled_to)
        failures = [v for group in groups if not group.left for v in _failures(group, skeleton.problem.world)]
        result.violations += [v for v in failures if v.kind != Breach.STEP]
        coarse = {v.phase for v in failures if v.kind == Breach.STEP}
        before = cost_of(skeleton.problem.world, trees, kept)
        result.cost = before + _cost(groups)
        if settings.polish:
            result.iterations += polish_groups(groups, seed, budget)
            result.cost_before, result.cost = result.cost, before + _cost(groups)
        result.paths = stored_paths(skeleton, motions(groups) | kept, trees, states, settings.slices)
        _refine(skeleton, result, states, sorted(coarse), settings, budget)
        if known:
            result.paths = [known.paths[k] if k in others and k in kept else p for k, p in enumerate(result.paths)]
        _solve_others(skeleton, result, states, [k for k in others if k not in kept], settings, seed, budget, thorough)
        result.feasible = not result.violations
    result.violations.sort(key=lambda v: (-v.amount, v.phase))
    result.seconds = time.perf_counter() - started
    return result


def _refine(
    skeleton: Skeleton, result: BoundResult, states: Sequence[tuple[Configuration, Configuration]],
    coarse: Sequence[int], settings: MotionSettings, budget: Budget,
) -> None:  # fmt: skip
    """More slices for phases in which nothing is wrong but that joints move far from one slice to the next."""
    from ..path.closed_chains import accepted

    for phase in coarse:
        found = accepted(skeleton, phase, result.paths[phase], *states[phase], settings, budget)
        result.paths[phase], wrong = found
        result.violations += wrong


def _solve_others(
    skeleton: Skeleton, result: BoundResult, states: Sequence[tuple[Configuration, Configuration]],
    others: Sequence[int], settings: MotionSettings, seed: Seed, budget: Budget, thorough: bool,
) -> None:  # fmt: skip
    """Phases that are no open chains, until one fails."""
    from ..path.closed_chains import solve_phase

    starts = PATHS.starts if thorough else PATHS.first_starts
    for phase in others:
        if result.violations:
            return
        random = seed.child("phase", phase).random()
        found = solve_phase(skeleton, phase, *states[phase], settings, random, budget, starts)
        result.paths[phase] = found.path
        result.violations += found.violations
        result.cost += found.cost
        if result.cost_before is not None:
            result.cost_before += found.cost
        result.iterations += found.iterations


def polish(
    skeleton: Skeleton, result: BoundResult, settings: MotionSettings, seed: Seed, budget: Budget, starts: int = 4
) -> BoundResult:
    """Cheaper motions between the same switches: each phase of a feasible result is optimised to the end, from its
    path and from `starts` bumped ones, and replaced where that is cheaper and passes the swept check. Phases that are
    no open chains stay as they are. Raises OutOfTime."""
    started = time.perf_counter()
    trees, states, _, others = chained(skeleton, result.configurations, settings)
    groups = grouped(skeleton, trees, states, settings)
    iterations = result.iterations
    for k, group in enumerate(groups):
        for row, phase in enumerate(group.batch.phases):
            modules = result.paths[phase].modules
            columns = [modules[module][:, 7 + joint] for module, joint in trees[phase].variables]
            group.paths[row] = np.stack(columns, axis=1)
        group.cost, group.solved = path_cost(group.batch, group.paths), np.ones(len(group.batch), bool)
        iterations += improve(group, seed.child("polish", k).random(), starts, budget)
    cost = _cost(groups)
    seconds = result.seconds + time.perf_counter() - started
    paths = stored_paths(skeleton, motions(groups), trees, states, settings.slices)
    for phase in others:
        paths[phase] = result.paths[phase]
    before = result.cost if result.cost_before is None else result.cost_before
    return BoundResult(result.bound, True, cost, seconds, iterations, result.configurations, paths, [], before)


def _cost(groups: Sequence[PhaseGroup]) -> float:
    return float(sum(group.cost.sum() for group in groups))


def chained(
    skeleton: Skeleton, configurations: Sequence[Configuration], settings: MotionSettings
) -> tuple[list[PhaseTree], list[tuple[Configuration, Configuration]], list[Violation], list[int]]:
    """The forest of each phase, the configurations at its two ends, where the given poses disagree with them, and the
    phases that are no open chains, whose forests are empty."""
    trees, states, drift, others = [], [], [], []
    current = configurations[0].copy()
    for index, phase in enumerate(skeleton.phases):
        given = configurations[index + 1]
        try:
            tree = phase_tree(skeleton.problem, index, phase, current, given)
            reached = arrive(tree, current, given)
        except UnsupportedPhase:
            others.append(index)
            tree, reached = PhaseTree(index), given
        for name, state in reached.modules.items():
            off = float(np.abs(state[:3] - given.modules[name][:3]).max())
            if off > settings.tolerance:
                drift.append(Violation(index, Breach.DRIFT, (name,), off, "m"))
        trees.append(tree)
        states.append((current, reached))
        current = reached
    return trees, states, drift, others


def grouped(
    skeleton: Skeleton, trees: Sequence[PhaseTree], states: Sequence[tuple[Configuration, Configuration]],
    settings: MotionSettings, alone: bool = False,
) -> list[PhaseGroup]:  # fmt: skip
    """Phases that move, stacked by structure; with `alone` as if what rests and can be moved were not there."""
    world = skeleton.problem.world
    touching = contacts(skeleton)
    stacked: dict[object, list[int]] = {}
    parts = {t.phase: make_parts(t, world) for t in trees if t.variables}
    for part in (part for both in parts.values() if alone for part in both):
        part.obstacles = [o for o in part.obstacles if o.owner in world.bodies and not world.bodies[o.owner].movable]
    for phase, (coarse, fine) in parts.items():
        stacked.setdefault((coarse.structure, fine.structure), []).append(phase)
    groups = []
    for members in stacked.values():
        batch = Batch(
            [parts[p] for p in members], [states[p] for p in members], world, touching,
            settings.slices, settings.margin, settings.collisions,
        )
        groups.append(start_group(batch))
    return groups


def motions(groups: Sequence[PhaseGroup]) -> dict[int, Array]:
    """The joint values of the phases of some groups."""
    return {int(p): group.paths[k] for group in groups for k, p in enumerate(group.batch.phases)}


def stored_paths(
    skeleton: Skeleton, motions: Mapping[int, Array], trees: Sequence[PhaseTree],
    states: Sequence[tuple[Configuration, Configuration]], slices: int,
) -> list[PhasePath]:
    """Samples of everything in every phase: modules that rest in constant rows, bodies that are carried. `motions` are
    the joint values `(times, joints)` of phases that move."""
    world = skeleton.problem.world
    paths = []
    for tree, (start, _) in zip(trees, states, strict=True):
        values = motions.get(tree.phase, np.zeros((slices + 1, 0)))
        modules, bodies = placed(tree, values, start, world)
        paths.append(PhasePath(modules, bodies, shortest_duration(world, modules)))
    return paths
