"""Stage 3: all declarations of a library checked and lowered, before any task is built."""

from __future__ import annotations

from collections.abc import Mapping

from ...langs import syntax
from ...langs.frozen import dataclass
from .. import ir
from ..checks.check_held import check_held
from ..checks.check_heuristics import check_heuristics
from ..checks.check_logic import PlacementChoice, check_derived, check_placements, check_rules, lower_predicates
from ..checks.check_motion import check_motions
from ..checks.check_usage import check_usage
from ..checks.context import Context, build_context
from ..checks.extents import check_extents
from ..checks.findings import Findings
from ..checks.formulas import check_formula
from ..checks.functions import check_functions
from ..checks.incomplete import keep_certain
from ..checks.names import Scope
from ..checks.terms import check_term
from ..checks.values import parameter_entries
from ..library import Library
from .module_types import check_modules
from .scene import SceneBuilder
from .scene_names import collect_objects


@dataclass(frozen=True, slots=True)
class Lifted:
    """The lifted IR of a library. `parsed` is False after errors of syntax or imports."""

    context: Context
    predicates: dict[str, ir.Predicate]
    derived: dict[str, ir.Derived]
    motions: dict[str, ir.MotionPredicate]
    rules: dict[str, ir.Rule]
    placements: tuple[PlacementChoice, ...]
    parsed: bool

    @property
    def library(self) -> Library:
        return self.context.library

    @property
    def findings(self) -> Findings:
        return self.context.findings

    def buildable(self, task: syntax.TaskDecl) -> bool:
        """Whether nothing that `task` is built of has errors."""
        library = self.library
        parts = [*library.scenes.values(), *library.modules.values(), *library.placements, task]
        sound = not self.findings.errors_in(m.path for m in library.models)
        return sound and self.parsed and self.context.expands and not self.findings.errors_within(d.span for d in parts)

    @property
    def logic_is_sound(self) -> bool:
        """Whether the logic has no errors, so that goals can be judged."""
        library = self.library
        parts = [*library.predicates.values(), *library.derived.values(), *library.rules.values()]
        return not self.findings.errors_within(d.span for d in parts)


def check_declarations(library: Library, findings: Findings, parsed: bool) -> Lifted:
    """Check every declaration. After errors of syntax or imports only those findings are kept that do not follow from
    what is missing."""
    context = build_context(library, findings if parsed else Findings(library.sources), check_term, check_formula)
    check_extents(context)
    predicates, derived = lower_predicates(context), check_derived(context)
    motions, rules, placements = check_motions(context), check_rules(context), check_placements(context)
    check_functions(context)
    check_heuristics(context, rules)
    check_modules(context)
    _check_scenes(context, library.scenes)
    _check_scenes(context, library.tasks)
    if parsed:
        check_usage(context, rules, derived, placements)
        check_held(context, motions, rules, placements)
    else:
        keep_certain(library, context.findings, findings)
        context.findings = findings
    return Lifted(context, predicates, derived, motions, rules, placements, parsed)


def _check_scenes(context: Context, table: Mapping[str, syntax.SceneDecl] | Mapping[str, syntax.TaskDecl]) -> None:
    for declaration in table.values():
        entries = parameter_entries(context, declaration.parameters)
        objects = collect_objects(context, declaration.items)
        SceneBuilder(context, objects).build(Scope("scene", entries, objects), declaration.items)
        is_task = isinstance(declaration, syntax.TaskDecl)
        if is_task and not _has_goal(context, declaration.items):
            where = context.findings.word(declaration.span, declaration.name)
            context.findings.report("E0506", where, f"task `{declaration.name}` has no goal", help="add `goal (…)`")


def _has_goal(context: Context, items: tuple[syntax.SceneItem, ...]) -> bool:
    seen: set[str] = set()
    waiting = list(items)
    while waiting:
        item = waiting.pop()
        if isinstance(item, syntax.GoalItem):
            return True
        if isinstance(item, syntax.ForItem | syntax.IfItem):
            waiting += item.items
        elif isinstance(item, syntax.SceneUse) and item.name not in seen:
            seen.add(item.name)
            scene = context.library.scenes.get(item.name)
            if scene is None:
                return True
            waiting += scene.items
    return False
