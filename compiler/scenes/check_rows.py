"""Rows of motion literals that hold at the start: what binds `during` them must be true before anything moves."""

from __future__ import annotations

from collections.abc import Mapping

from .. import ir
from ..checks.findings import Findings

TOLERANCES = {"m": 2e-3, "rad": 5e-3, "1": 5e-3}
"""By how much a row may be missed, by its unit, as in a plan that is checked."""


def check_rows(findings: Findings, problem: ir.Problem) -> None:
    """Report each `during` row of a literal at the start that is false there. Rows `at switch` bind where an action
    adds a literal, so they ask nothing of the start; `keep` rows hold what the start has. Loads CasADi only where there
    are such rows."""
    for literal in sorted(problem.init_motion):
        motion = problem.motions[literal[0]]
        for row in motion.rows:
            if row.when == "during":
                _check(findings, problem, motion, row, literal)


def _check(
    findings: Findings, problem: ir.Problem, motion: ir.MotionPredicate, row: ir.Row, literal: ir.Fact
) -> None:
    from ..motion.constraints import arguments, units
    from ..motion.loaded_rows import speaks_of_loads

    binding = {v.name: name for v, name in zip(motion.variables, literal[1:], strict=True)}
    names = arguments(row, motion.variables)
    if speaks_of_loads(row):
        misses = _loaded_residuals(problem, motion, row, binding)
    else:
        misses = _residuals(problem.world, row, names, [binding.get(n, n) for n in names])
    if row.operator == "=":
        misses = [abs(miss) for miss in misses]
    told = units(row)
    over = [(miss, told[min(k, len(told) - 1)]) for k, miss in enumerate(misses)]
    wrong = [(miss / TOLERANCES[unit], miss, unit) for miss, unit in over if miss > TOLERANCES[unit]]
    if wrong:
        _, miss, unit = max(wrong)
        shown = f"{miss:.3g} {'' if unit == '1' else unit}".rstrip()
        findings.report(
            "E0520",
            row.span,
            f"`[{' '.join(literal)}]` holds at the start, but this row is missed there by {shown}",
            labels=[(motion.span, "declared here")] if motion.span else [],
        )


def _loaded_residuals(
    problem: ir.Problem, motion: ir.MotionPredicate, row: ir.Row, binding: Mapping[str, str]
) -> list[float]:
    """Those of a row about loads, as shares of its bound; none where closed loops leave loads open."""
    import numpy as np

    from ..motion.constraints import BodyKind, RestKind
    from ..motion.loaded_rows import loaded_row

    made = loaded_row(problem, problem.init_motion, row, motion.variables, binding)
    if made is None:
        return [0.0]
    world, values, constants = problem.world, list[float](), list[float]()
    for name in made.slots:
        module = world.modules.get(name)
        values += world.bodies[name].pose if module is None else (*module.pose, *module.joints)
    for name, kind in zip(made.objects, made.kinds, strict=True):
        if isinstance(kind, RestKind):
            constants += world.bodies[name].pose
        if isinstance(kind, BodyKind | RestKind) and isinstance(kind.shape, str):
            constants += world.bodies[name].shape.size
    return [float(x) for x in made.stage.values(np.array([values]), np.array([constants]))[0]]


def _residuals(world: ir.World, row: ir.Row, names: tuple[str, ...], objects: list[str]) -> list[float]:
    """How far each component of a row is from holding: above 0 is wrong, for an equality what is not 0."""
    import numpy as np

    from ..motion.constraints import EffectorKind, Kind, RestKind, stage

    kinds: list[Kind] = []
    constants: list[float] = []
    slots: dict[str, tuple[float, ...]] = {}
    for name in objects:
        found = world.effector(name)
        module = found[0] if found else world.modules.get(name)
        if module is not None:
            slots.setdefault(module.name, (*module.pose, *module.joints))
            kinds.append(EffectorKind(module.type, found[1].name if found else "", [*slots].index(module.name)))
            continue
        body = world.bodies[name]
        whole = body.shape.kind == ir.ShapeKind.CONVEX
        kinds.append(RestKind(body.shape if whole else body.shape.kind, body.mass))
        constants += [*body.pose, *(() if whole else body.shape.size)]
    values = np.array([[x for slot in slots.values() for x in slot]], dtype=float)
    found_rows = stage(row, names, tuple(kinds)).values(values, np.array([constants], dtype=float))
    return [float(x) for x in found_rows[0]]
