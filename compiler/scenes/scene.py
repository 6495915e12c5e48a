"""Scenes and tasks: loops unrolled, bodies and modules put in their places, facts, goals, guide and options collected.

The same walk checks a declaration whose parameters have no values yet: then nothing is placed, loops are entered once
and both sides of a condition are looked at.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import field

from ...langs import syntax
from ...langs.frozen import dataclass
from ...langs.source import MAX_DEPTH, Span
from .. import ir
from ..checks.binders import bind, spend, unrolled
from ..checks.chain_bounds import check_chain_bounds
from ..checks.context import Context
from ..checks.evaluate import truth
from ..checks.formulas import check_formula, check_literal
from ..checks.kinds import ANGLE, LENGTH
from ..checks.names import Entry, Objects, Scope
from ..checks.shapes import shape
from ..checks.terms import check_term
from ..checks.values import bind_arguments, number, vector
from ..physics.masses import shape_volume
from ..physics.statements import stated
from ..poses import make, yaw
from .happenings import Way, check_breakdown, check_way
from .module_types import BuiltModule, build_module, effector_types, entries_key
from .placing import Support, has_flat_top, module_pose, top_of
from .scene_names import base_and_indices, full_name
from .task_options import check_options

MOST_THINGS = 10_000
"""How many bodies and modules a scene may have; with ten times fewer, search still takes moments."""


@dataclass(frozen=True, slots=True)
class Standing:
    """Something put `on` a support at the start: the object, its type, and the name and type of the support."""

    subject: str
    subject_type: str
    support: str
    support_type: str
    span: Span


@dataclass(slots=True)
class BuiltScene:
    """What the text of a task amounts to. `robots` maps a module to its declared type (the parameters of which may
    differ from the default)."""

    bodies: dict[str, ir.Body] = field(default_factory=dict)
    modules: dict[str, ir.Module] = field(default_factory=dict)
    robots: dict[str, str] = field(default_factory=dict)
    standing: list[Standing] = field(default_factory=list)
    facts: list[ir.Literal] = field(default_factory=list)
    goals: list[ir.Formula] = field(default_factory=list)
    goal_span: Span | None = None
    guide: tuple[syntax.HeuristicDecl, dict[str, Entry], Span] | None = None
    options: ir.Options = field(default_factory=ir.Options)
    ways: list[Way] = field(default_factory=list)
    breakdowns: list[ir.Breakdown] = field(default_factory=list)


class SceneBuilder:
    """One walk over the items of a scene or task."""

    def __init__(self, context: Context, objects: Objects) -> None:
        self.context = context
        self.findings = context.findings
        self.objects = objects
        self.built = BuiltScene()
        self.spans: dict[str, Span] = {}
        self.unplaced: set[str] = set()
        self.module_types: dict[tuple[str, tuple[float | None, ...]], BuiltModule | None] = {}
        self.open_scenes: list[str] = []
        self.full = False
        self.late: list[tuple[Scope, syntax.SceneItem]] = []

    def build(self, scope: Scope, items: Sequence[syntax.SceneItem]) -> BuiltScene:
        """Place everything first, then read facts, goals and guides, which may speak of all of it."""
        self.walk(scope, items)
        for inner, item in self.late:
            self.read(inner, item)
        return self.built

    def walk(self, scope: Scope, items: Sequence[syntax.SceneItem]) -> None:
        for item in items:
            match item:
                case syntax.BodyItem():
                    self.add_body(scope, item)
                case syntax.RobotItem():
                    self.add_robot(scope, item)
                case syntax.ForItem():
                    self.loop(scope, item)
                case syntax.IfItem():
                    self.branch(scope, item)
                case syntax.SceneUse():
                    self.use_scene(scope, item)
                case _:
                    self.late.append((scope, item))

    def read(self, scope: Scope, item: syntax.SceneItem) -> None:
        match item:
            case syntax.FactItem():
                literal = check_literal(self.context, scope, item.literal)
                self.built.facts += [literal] if literal is not None else []
            case syntax.GoalItem():
                self.add_goal(scope, item)
            case syntax.GuideUse():
                self.use_guide(scope, item)
            case syntax.OptionsItem():
                self.built.options = check_options(self.context, scope, item, self.built.options)
            case syntax.CourseItem() | syntax.DisturbanceItem():
                way = check_way(self.context, scope, item)
                self.built.ways += [way] if way is not None else []
            case syntax.BreakdownItem():
                breakdown = check_breakdown(self.context, scope, item)
                self.built.breakdowns += [breakdown] if breakdown is not None else []
            case _:
                raise AssertionError(type(item).__name__)

    def add_goal(self, scope: Scope, item: syntax.GoalItem) -> None:
        """The conjuncts of a goal, which may stand in a loop; a second goal elsewhere is an error."""
        first = self.built.goal_span or item.span
        self.built.goal_span = first
        if scope.values_known and first != item.span:
            help = "join them: `goal (…) and (…)`"
            self.findings.report("E0511", item.span, "a task has one goal", help=help, labels=[(first, "first goal")])
        goal_scope = Scope("goal", scope.entries, scope.objects, scope.values_known)
        goals = [check_formula(self.context, goal_scope, f) for f in item.formulas]
        for goal in goals:
            check_chain_bounds(self.context, goal)
        self.built.goals += goals

    def loop(self, scope: Scope, item: syntax.ForItem) -> None:
        over_objects = [b for b in item.binders if not isinstance(b.type, syntax.RangeType)]
        for binder in over_objects:
            self.findings.report(
                "E0208", binder.type.span, "loops of a scene run over numbers", help="use a range such as `1 .. n`"
            )
        if not scope.values_known or over_objects:
            inner, _ = bind(self.context, scope, item.binders)
            self.walk(inner, item.items)
            return
        for inner in unrolled(self.context, scope, item.binders) or ():
            if len(self.spans) > MOST_THINGS:
                if not self.full:
                    self.findings.report("E0510", item.span, f"this loop makes more than {MOST_THINGS} things")
                self.full = True
                return
            self.walk(inner, item.items)

    def branch(self, scope: Scope, item: syntax.IfItem) -> None:
        chosen = truth(check_formula(self.context, scope, item.condition))
        if not scope.values_known or chosen:
            self.walk(scope, item.items)

    def use_scene(self, scope: Scope, item: syntax.SceneUse) -> None:
        scenes = self.context.library.scenes
        scene = scenes.get(item.name)
        where = self.findings.word(item.span, item.name)
        if scene is None:
            self.findings.unknown("E0107", "scene", item.name, where, scenes)
            return
        declared = self.findings.word(scene.span, scene.name)
        entries = bind_arguments(self.context, scope, scene.parameters, item.args, item.span, declared)
        if entries is None or not scope.values_known:
            return
        if item.name in self.open_scenes:
            ring = " uses ".join([*self.open_scenes, item.name])
            self.findings.report("E0512", where, f"scene `{item.name}` uses itself: {ring}")
            return
        if len(self.open_scenes) >= MAX_DEPTH:
            if not self.full:
                self.findings.report("E0008", where, f"scenes use each other more than {MAX_DEPTH} deep")
            self.full = True
            return
        if not spend(self.context, 1, where):
            return
        self.open_scenes.append(item.name)
        self.walk(Scope("scene", entries, self.objects, True), scene.items)
        self.open_scenes.pop()

    def use_guide(self, scope: Scope, item: syntax.GuideUse) -> None:
        heuristics = self.context.library.heuristics
        heuristic = heuristics.get(item.name)
        if heuristic is None:
            where = self.findings.word(item.span, item.name)
            self.findings.unknown("E0106", "heuristic", item.name, where, heuristics)
            return
        declared = self.findings.word(heuristic.span, heuristic.name)
        entries = bind_arguments(self.context, scope, heuristic.parameters, item.args, item.span, declared)
        if self.built.guide is not None:
            first = [(self.built.guide[2], "first guide")]
            self.findings.report("E0511", item.span, "a task has at most one guide", labels=first)
        elif entries is not None:
            self.built.guide = (heuristic, entries, item.span)

    def name(self, scope: Scope, term: syntax.Term) -> str | None:
        """The full name of a new thing, or None where its indices are not known."""
        base, indices = base_and_indices(term)
        name = full_name(self.context, base, [(i, check_term(self.context, scope, i)) for i in indices])
        if name is None or not scope.values_known:
            return None
        if name in self.spans:
            first = [(self.spans[name], "first declared here")]
            again = self.spans[name] == term.span
            help = f"count it by the variable of the loop: `{base}[k]`" if again else "give one of them another name"
            self.findings.report("E0507", term.span, f"there are two things named `{name}`", help=help,
                                 labels=[] if again else first)  # fmt: skip
            return None
        self.spans[name] = term.span
        return name

    def add_body(self, scope: Scope, item: syntax.BodyItem) -> None:
        self.check_body_type(item)
        name = self.name(scope, item.name)
        form = shape(self.context, scope, item.shape)
        pose = self.body_pose(scope, item, form)
        if name is None:
            return
        assert self.objects.ground is not None
        self.objects.ground[name] = item.type
        if form is None or pose is None:
            self.unplaced.add(name)
            return
        place, support = pose
        said = stated(self.context, scope, item, ("mass", "density", "holds"), "a body")
        mass = said.weight(shape_volume(form))
        self.built.bodies[name] = ir.Body(name, item.type, form, place, False, item.span, mass, said.holds)
        if support is not None:
            self.built.standing.append(Standing(name, item.type, support.name, support.type, item.span))

    def check_body_type(self, item: syntax.BodyItem) -> None:
        library = self.context.library
        where = self.findings.word(item.span, item.type)
        if item.type not in library.types:
            self.findings.unknown("E0102", "type", item.type, where, [t for t in library.types if t != "module"])
        elif not library.is_a(item.type, "object") or library.is_a(item.type, "effector"):
            self.findings.report("E0202", where, f"`{item.type}` is not a type of bodies")

    def body_pose(
        self, scope: Scope, item: syntax.BodyItem, form: ir.Shape | None
    ) -> tuple[ir.Pose, Support | None] | None:
        context = self.context
        heading = 0.0 if item.heading is None else number(context, scope, item.heading, ANGLE, "a heading")
        if item.on is None and item.at is None:
            self.findings.report(
                "E0501", item.span, "this body has no place", help="add `at (x, y, z)` or `on` something"
            )
            return None
        if item.on is None:
            assert item.at is not None
            at = vector(context, scope, item.at, 3, LENGTH, "the place of a body")
            if at is None or heading is None:
                return None
            return make((at[0], at[1], at[2]), yaw(heading)), None
        support = self.support(scope, item.on)
        spot = self.spot(scope, item.at, support)
        if support is None or spot is None or heading is None or form is None:
            return None
        x, y, z = support.point(spot)
        return make((x, y, z + top_of(form)), yaw(support.heading + heading)), support

    def support(self, scope: Scope, term: syntax.Term) -> Support | None:
        """What carries something, with its top face: a body, or an end of a robot."""
        typed = check_term(self.context, scope, term)
        if not typed.kind.known:
            return None
        if typed.kind.name != "object" or not isinstance(typed.term, ir.Object):
            self.findings.report("E0208", term.span, f"`on` needs a body, not {typed.kind}")
            return None
        body = self.built.bodies.get(typed.term.name)
        if body is None:
            if typed.term.name in self.unplaced:
                return None
            module = self.built.modules.get(typed.term.name.rpartition(".")[0])
            if module is not None:
                return self.deck(term, module, typed.term.name)
            if scope.values_known or not self.context.library.is_a(typed.kind.type, "object"):
                robot = self.context.library.modules.get(typed.kind.type)
                named = [f"`{typed.term.name}.{e}`" for e in effector_types(robot)] if robot is not None else []
                help = f"name one of its ends: {', '.join(named)}" if named else None
                message = f"`{typed.term.name}` is not a body that can carry something"
                self.findings.report("E0501", term.span, message, help=help)
            return None
        if not has_flat_top(body.shape):
            self.findings.report("E0501", term.span, f"`{body.name}` is a {body.shape.kind} and has no flat top")
            return None
        return Support.of(body)

    def deck(self, term: syntax.Term, module: ir.Module, name: str) -> Support | None:
        """The top of an end of a robot, as it is at the start."""
        end = module.type.effector(name.rpartition(".")[2])
        if end.shape is None or not has_flat_top(end.shape):
            what = "has no shape" if end.shape is None else f"is a {end.shape.kind} and has no flat top"
            self.findings.report("E0501", term.span, f"`{name}` {what}")
            return None
        support = Support.of_end(name, module, end)
        if support is None:
            help = "what lies on it is put there while its joints are at `home`: give them values at which it is level"
            self.findings.report("E0501", term.span, f"the top of `{name}` is not level at the start", help=help)
        return support

    def spot(self, scope: Scope, term: syntax.Term | None, support: Support | None) -> tuple[float, float] | None:
        if term is None:
            return 0.0, 0.0
        at = vector(self.context, scope, term, 2, LENGTH, "a place on something")
        if at is None:
            return None
        if support is not None and not support.carries((at[0], at[1])):
            self.findings.report(
                "E0501",
                term.span,
                f"({at[0]:g} m, {at[1]:g} m) lies beside the top of `{support.name}`",
                help=f"its top is {support.extent}; places are measured from its centre",
            )
            return None
        return at[0], at[1]

    def add_robot(self, scope: Scope, item: syntax.RobotItem) -> None:
        module = self.module_of(item)
        if module is None:
            return
        name = self.name(scope, item.name)
        built = self.module_type(scope, item, module)
        pose = self.robot_pose(scope, item, module, built)
        if name is None or built is None or pose is None:
            return
        place, support = pose
        homes = tuple(j.home for j in built.type.joints)
        self.built.modules[name] = ir.Module(name, built.type, place, homes, item.span)
        self.built.robots[name] = module.name
        assert self.objects.ground is not None
        self.objects.ground[name] = module.name
        for end in built.type.effectors:
            self.objects.ground[f"{name}.{end.name}"] = end.type
        for fact in built.facts:
            args = tuple(ir.Object(f"{name}.{a.name}", a.span) for a in fact.args if isinstance(a, ir.Object))
            self.built.facts.append(ir.Literal(fact.predicate, args, fact.motion, fact.span))
        if support is not None and item.effector is not None:
            end_type = effector_types(module)[item.effector]
            subject = f"{name}.{item.effector}"
            self.built.standing.append(Standing(subject, end_type, support.name, support.type, item.span))

    def module_of(self, item: syntax.RobotItem) -> syntax.ModuleDecl | None:
        modules = self.context.library.modules
        module = modules.get(item.type)
        if module is None:
            where = self.findings.word(item.span, item.type)
            if item.type in self.context.library.types:
                help = f"`{item.type}` is a type of bodies, which have a shape: `{item.type} b: sphere(4 cm)`"
                self.findings.report("E0108", where, f"no module type is named `{item.type}`", help=help)
            else:
                self.findings.unknown("E0108", "module type", item.type, where, modules)
            return None
        if item.effector is not None and item.effector not in effector_types(module):
            where = self.findings.word(item.span, item.effector, 0)
            if where != item.span:  # else recovery named an end that the text forgot, as it has told
                self.findings.unknown("E0117", "effector", item.effector, where, effector_types(module))
            return None
        return module

    def module_type(self, scope: Scope, item: syntax.RobotItem, module: syntax.ModuleDecl) -> BuiltModule | None:
        declared = self.findings.word(module.span, module.name)
        entries = bind_arguments(self.context, scope, module.parameters, item.args, item.span, declared)
        if entries is None or not scope.values_known:
            return None
        key = (module.name, entries_key(entries))
        if key not in self.module_types:
            values = ", ".join(f"{n} = {e.typed.value:g}" for n, e in entries.items() if e.typed.value is not None)
            name = f"{module.name}({values})" if item.args else module.name
            self.module_types[key] = build_module(
                self.context, module, Scope("scene", entries, values_known=True), name
            )
        return self.module_types[key]

    def robot_pose(
        self, scope: Scope, item: syntax.RobotItem, module: syntax.ModuleDecl, built: BuiltModule | None
    ) -> tuple[ir.Pose, Support | None] | None:
        context = self.context
        heading = 0.0 if item.heading is None else number(context, scope, item.heading, ANGLE, "a heading")
        if item.on is None:
            if item.at is None:
                self.findings.report("E0501", item.span, "this robot has no place", help="add `at (x, y, z)`")
                return None
            at = vector(context, scope, item.at, 3, LENGTH, "the place of a robot")
            if at is None or heading is None:
                return None
            return make((at[0], at[1], at[2]), yaw(heading)), None
        support = self.support(scope, item.on)
        spot = self.spot(scope, item.at, support)
        if support is None or spot is None or heading is None or built is None or item.effector is None:
            return None
        return module_pose(built.type, item.effector, support.point(spot), support.heading + heading), support
