"""All checks of a plan in order, from its sources to its last sample."""

from __future__ import annotations

from ...compiler import ir
from ...langs.diagnostics import SourceError
from ...langs.source import Source
from ..plan import Plan, VerdictRecord
from .collision import check_collisions
from .constraints import check_constraints
from .findings import Findings, place_of
from .kinematics import Kinematics, motion_of
from .motion import check_motion
from .replay import replay
from .scene import check_scene, check_sources
from .structure import check_structure


def verify(plan: Plan) -> VerdictRecord:
    """The verdict on a plan, from nothing but what stands in it. Raises MissingLibrary."""
    findings = Findings()
    if not check_sources(plan, findings):
        return findings.verdict()
    problem = _problem(plan, findings)
    return findings.verdict() if problem is None else _examine(plan, problem, findings)


def check(plan: Plan, problem: ir.Problem) -> VerdictRecord:
    """The verdict on a plan for a problem that is already compiled. Raises MissingLibrary."""
    return _examine(plan, problem, Findings())


def _problem(plan: Plan, findings: Findings) -> ir.Problem | None:
    """The task, compiled anew from the stored sources."""
    from ...compiler.pipeline import compile_problem

    sources = {s.path: Source(s.path, s.text) for s in plan.task.sources}
    try:
        return compile_problem(sources, plan.task)
    except SourceError as error:
        for diagnostic in error.diagnostics:
            if diagnostic.is_error:
                message = f"{diagnostic.code} {diagnostic.message}"
                findings.fail("source", message, place=place_of(diagnostic.span))
        return None


def _examine(plan: Plan, problem: ir.Problem, findings: Findings) -> VerdictRecord:
    sound = check_structure(plan, findings)
    same = check_scene(plan, problem, findings)
    story = replay(problem, plan, findings)
    if sound and same:
        kinematics = {m.name: Kinematics(m) for m in plan.modules}
        motion = motion_of(plan, kinematics)
        check_motion(problem, plan, story, motion, findings)
        check_constraints(problem, plan, story, motion, findings)
        check_collisions(plan, motion, kinematics, findings)
    return findings.verdict()
