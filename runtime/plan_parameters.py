"""The parameters of a plan, as one would give them to its task."""

from __future__ import annotations

from ..langs import syntax
from ..langs.source import Source
from .plan import Plan


def parameter_texts(plan: Plan, sources: list[Source]) -> dict[str, str]:
    """The parameters' values as one would type them, with the unit of their type."""
    from ..langs.parser import parse

    kinds: dict[str, str] = {}
    for source in sources:
        for declaration in parse(source)[0].declarations:
            if isinstance(declaration, syntax.TaskDecl) and declaration.name == plan.task.name:
                kinds = {p.name: p.type.name for p in declaration.parameters if isinstance(p.type, syntax.NamedType)}
                break
        if kinds:
            break
    units = {"length": " m", "angle": " rad", "time": " s", "speed": " m/s", "mass": " kg", "density": " kg/m^3",
             "force": " N", "torque": " N m", "inertia": " kg m^2"}  # fmt: skip
    return {name: f"{value!r}{units.get(kinds.get(name, ''), '')}" for name, value in plan.task.parameters.items()}
