"""Stages 4 to 6: one task with values for its parameters becomes an `ir.Problem`."""

from __future__ import annotations

import dataclasses
import random
from collections.abc import Mapping

from ...langs import syntax
from ...langs.diagnostics import UsageError
from .. import ir
from ..checks.check_heuristics import lower_heuristic
from ..checks.context import Context
from ..checks.kinds import VALUE_TYPES
from ..checks.names import Entry, Scope, Typed
from ..checks.relaxation import Relaxation, RelaxedWorld, followers, movable
from ..checks.values import bind_arguments
from ..objectives import check_energy
from .check_loops import check_loops
from .check_rows import check_rows
from .check_start import check_start
from .check_strength import check_joint_names, check_strength
from .happenings import breakdowns, courses
from .initial import carrying, initial_state
from .lifted import Lifted
from .marks import with_marks
from .reachability import check_goal
from .resting import resting, tell
from .scene import BuiltScene, SceneBuilder
from .scene_names import collect_objects
from .undriven import without_drives
from .ways import check_ways


def instantiate(
    lifted: Lifted, task: syntax.TaskDecl, values: Mapping[str, float | int], seed: int
) -> ir.Problem | None:
    """The problem of `task`; None after errors, which are in the findings of `lifted`."""
    context = dataclasses.replace(lifted.context, random=random.Random(seed), rounds=0)
    entries = _task_entries(context, task, values)
    errors = context.findings.errors
    if entries is None:
        return None
    objects = collect_objects(context, task.items)
    objects.ground = {}
    built = SceneBuilder(context, objects).build(Scope("scene", entries, objects, values_known=True), task.items)
    init, init_motion = initial_state(context, built, lifted.placements, lifted.predicates, lifted.motions)
    if context.findings.errors > errors:
        return None
    happenings = courses(context.findings, built.bodies, built.ways), breakdowns(context.findings, built.breakdowns)
    problem = _problem(lifted, context, task, entries, built, (init, init_motion), happenings, seed)
    carried = [(s.subject, s.support) for s in built.standing]
    check_start(context.findings, problem.world, carried)
    check_ways(context.findings, problem.world, carried)
    if context.findings.errors == errors:
        check_loops(context.findings, problem)
        check_rows(context.findings, problem)
        check_joint_names(context.findings, problem)
        check_strength(context.findings, problem)
        _check_energy(context, problem)
    return problem


def _task_entries(
    context: Context, task: syntax.TaskDecl, values: Mapping[str, float | int]
) -> dict[str, Entry] | None:
    """The parameters of the task: given values, else the defaults."""
    known: dict[str, Entry] = {}
    for parameter in task.parameters:
        if parameter.name in values and isinstance(parameter.type, syntax.NamedType):
            kind = VALUE_TYPES[parameter.type.name]
            known[parameter.name] = Entry(Typed(ir.Number(values[parameter.name]), kind), parameter.span)
        else:
            one = bind_arguments(context, Scope("scene", known), [parameter], [], task.span, task.span)
            if one is None:
                return None
            known.update(one)
    return known


def _check_energy(context: Context, problem: ir.Problem) -> None:
    """Reports E0524."""
    try:
        if problem.options.minimise is not None:
            check_energy(problem.options.minimise, problem.options.physics)
    except UsageError as error:
        assert error.diagnostic is not None
        context.findings.add(error.diagnostic)


def _with_resting(
    lifted: Lifted,
    context: Context,
    built: BuiltScene,
    relaxation: Relaxation,
    start: frozenset[ir.Fact],
    settled: set[str],
) -> tuple[frozenset[ir.Fact], set[str]]:
    """The motion literals at the start, with those of what lies on what can be moved, and all that can be moved. Rules
    that take a thing and delete nothing would not get it free of what it lies on: what they take is left."""
    moving = movable(relaxation, lifted.motions, start)
    effects = [e for rule in relaxation.world.rules.values() for e in ir.effects_of(rule.effects)]
    deleted = any(e.negated and e.literal.motion for e in effects)
    taken = movable(relaxation, lifted.motions, ())
    while True:
        following = {fact[1 + place] for fact in start for place in followers(lifted.motions[fact[0]])}
        found = resting(built, lifted.library.types, moving, settled | following)
        if not deleted:
            found = [s for s in found if s.subject not in taken]
        more = carrying(context, lifted.placements, found)
        if not more:
            return start, moving
        tell(context.findings, (s for s in found if any(s.subject in fact for fact in more)))
        settled = settled | {s.subject for s in found}
        start |= more
        moving = movable(relaxation, lifted.motions, start)


def _problem(
    lifted: Lifted,
    context: Context,
    task: syntax.TaskDecl,
    entries: Mapping[str, Entry],
    built: BuiltScene,
    init: tuple[frozenset[ir.Fact], frozenset[ir.Fact]],
    happenings: tuple[tuple[ir.Course, ...], tuple[ir.Breakdown, ...]],
    seed: int,
) -> ir.Problem:
    library = lifted.library
    objects = {b.name: b.type for b in built.bodies.values()}
    objects.update(built.robots)
    for module in built.modules.values():
        objects.update({f"{module.name}.{e.name}": e.type for e in module.type.effectors})
    world = RelaxedWorld(library.types, objects, lifted.derived, lifted.predicates, lifted.rules, init[0])
    relaxation = Relaxation(world)
    settled = {s.subject for s in built.standing} | {course.body for course in happenings[0]}
    start, moving = _with_resting(lifted, context, built, relaxation, init[1], settled)
    bodies = {n: dataclasses.replace(b, movable=n in moving) for n, b in built.bodies.items()}
    bodies = with_marks(bodies, {course.body for course in happenings[0]}, library.types)
    modules = without_drives(context.findings, library.modules, built.robots, built.modules, relaxation, lifted.motions)
    heuristic = None
    if built.guide is not None:
        declaration, arguments, _ = built.guide
        heuristic = lower_heuristic(context, declaration, arguments)
    goal = built.goals[0] if len(built.goals) == 1 else ir.And(tuple(built.goals))
    if lifted.logic_is_sound:
        check_goal(context.findings, relaxation, goal)
    parameters = {n: e.typed.value for n, e in entries.items() if e.typed.value is not None}
    return ir.Problem(
        task=task.name,
        file=library.path,
        seed=seed,
        parameters=parameters,
        types=library.types,
        objects=objects,
        predicates=lifted.predicates,
        derived=lifted.derived,
        motions=lifted.motions,
        rules=lifted.rules,
        heuristic=heuristic,
        init=init[0],
        init_motion=start,
        goal=goal,
        world=ir.World(modules, bodies, *happenings),
        options=built.options,
        sources=library.sources,
        files=library.foreign,
        names=library.names,
    )
