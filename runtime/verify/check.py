"""All checks of a plan in order, from its sources to its last sample."""

from __future__ import annotations

from ...compiler import ir
from ...langs.diagnostics import SourceError
from ...langs.source import Source
from ..budget import Budget
from ..plan import Plan, VerdictRecord
from ..plan_parameters import parameter_texts
from .collision import check_collisions
from .constraints import check_constraints
from .couplings import check_couplings
from .drives import check_drives
from .findings import Findings
from .happenings import TooManyCorners, check_breakdowns, check_courses, check_happenings, happenings_of
from .kinematics import Kinematics, check_kinematics, motion_of
from .limits import LIMITS, share_of
from .links import links_of
from .motion import check_motion
from .provenance import check_against, check_sources, check_task, check_windows, files_beside
from .rates import check_rates
from .replay import replay
from .sampler import Sampler, curves_of
from .samples import check_samples
from .scene import check_scene
from .statics import check_statics
from .structure import check_structure
from .switches import check_switches


def verify(plan: Plan, budget: Budget | None = None, against: ir.Problem | None = None) -> VerdictRecord:
    """The verdict on a plan, from nothing but what stands in it. It is refused where its task is not the one of
    `against`, which also lends the files that a plan of format 1 lacks. Raises MissingLibrary, and OutOfTime once the
    budget is spent."""
    findings = Findings(budget)
    if not check_sources(plan, findings):
        return findings.verdict()
    problem = _problem(plan, findings, against)
    if problem is None or (against is not None and not check_against(problem, against, findings)):
        return findings.verdict()
    return _examine(plan, problem, findings)


def check(plan: Plan, problem: ir.Problem) -> VerdictRecord:
    """The verdict on a plan for a problem that is already compiled. Raises MissingLibrary."""
    return _examine(plan, problem, Findings())


def _problem(plan: Plan, findings: Findings, against: ir.Problem | None) -> ir.Problem | None:
    """The task, compiled from nothing but the stored sources and files, and those of `against`; anew, unless this
    process compiled just these before."""
    from ...compiler.pipeline import UsageError, compile_sources, compiled_before

    sources = [Source(s.path, s.text) for s in plan.task.sources]
    if not sources:
        findings.fail("source", "the plan holds no source text")
        return None
    try:
        lent = {} if against is None else files_beside(plan.task.file, against)
        files = lent | {f.path: f.data for f in plan.task.files}
        problem = compiled_before(sources, plan.task.name, plan.task.parameters, plan.task.seed, files)
        if problem is None:
            texts = parameter_texts(plan, sources)
            problem, _ = compile_sources(sources, plan.task.name, texts, plan.task.seed, files)
        findings.names = problem.names
    except SourceError as error:
        for diagnostic in error.diagnostics:
            if diagnostic.is_error:
                message = f"{diagnostic.code} {diagnostic.message}"
                message += f" ({diagnostic.help})" if diagnostic.help is not None else ""
                findings.fail("source", message, place=findings.place_of(diagnostic.span))
        if not findings.failures:
            findings.fail("source", "the stored sources do not compile")
        return None
    except UsageError as error:
        findings.fail("source", str(error))
        return None
    return problem if check_task(plan, problem, findings) else None


def _examine(plan: Plan, problem: ir.Problem, findings: Findings) -> VerdictRecord:
    findings.share = share_of(problem.world)
    check_windows(plan, findings)
    findings.at_rest = bool(problem.world.courses or problem.world.breakdowns) and not (plan.courses or plan.breakdowns)
    samples = check_structure(plan, findings)
    same = check_scene(plan, problem, findings) and check_happenings(plan, problem, findings)
    if samples is None or not same:
        replay(problem, plan, findings)
        return findings.verdict()
    kinematics = {m.name: Kinematics(m) for m in plan.modules}
    motion = motion_of(plan, kinematics, samples)
    check_kinematics(motion, kinematics, findings)
    story = replay(problem, plan, findings, motion)
    happenings = happenings_of(problem, plan, story.modes)
    links = links_of(problem, story.modes, motion, happenings, LIMITS["rest_m"])
    sampler = Sampler(problem.world, motion, kinematics, happenings, links, curves_of(plan, findings.check_time))
    check_motion(problem, plan, motion, sampler.curves, happenings, findings)
    check_samples(motion, sampler, findings)
    check_switches(problem, plan, story, sampler.curves, findings)
    check_rates(problem, plan, motion, findings)
    check_couplings(plan, motion, findings)
    check_drives(problem, plan, story.modes, sampler, findings)
    check_courses(problem, happenings, motion, findings)
    check_breakdowns(problem, plan, motion, sampler.curves, findings)
    try:
        check_statics(problem, plan, story.modes, story.final, sampler, findings)
        check_constraints(problem, plan, story, motion, sampler, findings)
        check_collisions(plan, motion, sampler, findings)
    except TooManyCorners as error:
        findings.fail("undecided", str(error))
    return findings.verdict()
