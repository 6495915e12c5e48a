"""The names that a scene or task declares, before anything of it is built."""

from __future__ import annotations

from collections.abc import Sequence

from ...langs import syntax
from ..checks.context import Context
from ..checks.names import Family, Objects
from ..checks.objects import object_name as full_name
from .module_types import effector_types

__all__ = ["base_and_indices", "collect_objects", "full_name"]


def base_and_indices(term: syntax.Term) -> tuple[str, list[syntax.Term]]:
    """`plate[i]` as its base name and its indices."""
    indices: list[syntax.Term] = []
    while isinstance(term, syntax.Index):
        indices.insert(0, term.index)
        term = term.base
    return (term.name if isinstance(term, syntax.Name) else ""), indices


def collect_objects(context: Context, items: Sequence[syntax.SceneItem]) -> Objects:
    """Everything that `items` and the scenes used there can declare. Reports one base name used for two types."""
    ends = {name: effector_types(module) for name, module in context.library.modules.items()}
    objects = Objects(ends=ends)
    seen: set[str] = set()
    waiting = list(reversed(items))
    while waiting:
        item = waiting.pop()
        match item:
            case syntax.BodyItem() | syntax.RobotItem():
                _add(context, item, objects)
            case syntax.ForItem() | syntax.IfItem():
                waiting += reversed(item.items)
            case syntax.SceneUse():
                scene = context.library.scenes.get(item.name)
                objects.incomplete |= scene is None
                if scene is not None and item.name not in seen:
                    seen.add(item.name)
                    waiting += reversed(scene.items)
            case _:
                pass
    return objects


def _add(context: Context, item: syntax.BodyItem | syntax.RobotItem, objects: Objects) -> None:
    base, indices = base_and_indices(item.name)
    if not base:
        context.findings.report("E0208", item.name.span, "a name such as `b` or `b[i]` is needed here")
        return
    first = objects.families.setdefault(base, Family(item.type, len(indices), item.name.span))
    if (first.type, first.indices) != (item.type, len(indices)):
        context.findings.report(
            "E0507",
            item.name.span,
            f"`{base}` is already the name of something else",
            labels=[(first.span, "declared here")],
        )
