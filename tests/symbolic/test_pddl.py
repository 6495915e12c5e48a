"""The PDDL export is positive STRIPS, declares what it uses, and means the same as the rules."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest

from tamplang.compiler.ir import Problem
from tamplang.compiler.pipeline import compile_problem, compile_text
from tamplang.compiler.symbolic.pddl import to_pddl
from tamplang.compiler.symbolic.pddl_plans import plan_lines
from tamplang.compiler.symbolic.successors import Successors
from tamplang.langs.diagnostics import UsageError
from tamplang.runtime.budget import Budget
from tamplang.runtime.planner.search.best_first import SkeletonSearch

from . import variants
from .problems import climb, pick_and_place

PROBLEMS = {"climb": lambda: climb(3, 2), "items": lambda: pick_and_place(3)}
ATOM = re.compile(r"\(([^()]+)\)")
State = frozenset[tuple[str, ...]]


@pytest.mark.parametrize("name", PROBLEMS)
def test_is_balanced_and_declares_its_predicates(name: str) -> None:
    problem: Problem = PROBLEMS[name]()
    domain, task = to_pddl(problem)
    for text in (domain, task):
        assert text.count("(") == text.count(")")
    declared = set(re.findall(r"\((\w+)(?: \?|\))", domain.partition("(:predicates")[2].partition("(:action")[0]))
    words = {"and", "not", "define", "domain", "problem"}
    used = set(re.findall(r"\((\w+)", domain.partition("(:action")[2] + task)) - words
    assert used <= declared
    for parameters, condition, effect in actions(domain):
        assert not re.search(r"\((not|or|exists|forall|when) ", condition)
        assert set(re.findall(r"\?\w+", condition + effect)) <= set(parameters.split())


def actions(domain: str) -> list[tuple[str, str, str]]:
    pattern = r":parameters \((.*?)\)\n    :precondition (.*?)\n    :effect (.*?)(?=\n  \(:action|\n\)\n)"
    return re.findall(pattern, domain, re.DOTALL)


def shortest(domain: str, task: str, most: int) -> int | None:
    """Breadth-first search on the text itself."""
    init = frozenset(tuple(a.split()) for a in ATOM.findall(task.partition("(:init")[2].partition("(:goal")[0]))
    goal = {tuple(a.split()) for a in ATOM.findall(task.partition("(:goal")[2])}
    schemas = []
    for _, condition, effect in actions(domain):
        gone = [tuple(a.split()) for a in re.findall(r"\(not \(([^()]+)\)\)", effect)]
        come = [tuple(a.split()) for a in ATOM.findall(re.sub(r"\(not \([^()]+\)\)", "", effect))]
        schemas.append(([tuple(a.split()) for a in ATOM.findall(condition)], gone, come))
    layer, seen, depth = {init}, {init}, 0
    while layer and depth <= most:
        if any(goal <= state for state in layer):
            return depth
        layer = {t for s in layer for schema in schemas for t in following(s, *schema)} - seen
        seen |= layer
        depth += 1
    return None


def following(state: State, condition: list, gone: list, come: list) -> set[State]:
    """All states after one action."""
    bindings: list[dict[str, str]] = [{}]
    by_name: dict[str, list[tuple[str, ...]]] = {}
    for fact in state:
        by_name.setdefault(fact[0], []).append(fact)
    for atom in sorted(condition, key=lambda a: any(x.startswith("?") for x in a)):
        bindings = [b for old in bindings for fact in by_name.get(atom[0], ()) if (b := unified(atom, fact, old))]
    found = set()
    for b in bindings:
        named = [{tuple(b.get(x, x) for x in atom) for atom in atoms} for atoms in (gone, come)]
        found.add(frozenset((state - named[0]) | named[1]))
    return found


def unified(atom: tuple[str, ...], fact: tuple[str, ...], old: dict[str, str]) -> dict[str, str] | None:
    b = {**old, "": ""}
    for pattern, value in zip(atom, fact, strict=True):
        if (b.setdefault(pattern, value) if pattern.startswith("?") else pattern) != value:
            return None
    return b


LENGTHS = [(lambda: climb(3, 2), 1), (lambda: climb(2, 1), 1), (lambda: pick_and_place(1), 0)]


@pytest.mark.parametrize("make, extra", LENGTHS)
def test_plans_are_as_long_as_ours(make: Callable[[], Problem], extra: int) -> None:
    """A goal with alternatives takes one action more."""
    problem = make()
    candidate = SkeletonSearch(problem, Successors(problem), "astar", Budget(20)).next()
    assert candidate is not None
    assert shortest(*to_pddl(problem), 8) == len(candidate.actions) + extra


EXAMPLES: dict[str, dict[str, str]] = {
    "chain_climb": {"modules": "3"}, "strut_bridge": {}, "quadruped": {"crawlers": "4"}, "terraces": {},
}  # fmt: skip


@pytest.mark.parametrize("name", EXAMPLES)
def test_plans_with_chains_are_plans_of_the_export(name: str) -> None:
    """Each action of a plan is one of the export's, and these lead from its start to its goal."""
    folder = Path(__file__).parents[2] / "examples"
    problem, _ = compile_problem(folder / f"{name}.tamp", name, EXAMPLES[name])
    candidate = SkeletonSearch(problem, Successors(problem), "astar", Budget(60)).next()
    assert candidate is not None
    domain, task = to_pddl(problem)
    state = {tuple(a.split()) for a in ATOM.findall(task.partition("(:init")[2].partition("(:goal")[0])}
    texts = dict(re.findall(r"\(:action (\w+)\n(.*?)(?=\n  \(:action|\n\)\n)", domain, re.DOTALL))
    for line in plan_lines(problem, [(a.rule, [str(v) for v in a.args]) for a in candidate.actions]):
        action, *things = line.strip("()").split()
        parameters, condition, effect = actions(f"{texts[action]}\n)\n")[0]
        binding = dict(zip(re.findall(r"\?\w+", parameters), things, strict=True))
        put = [tuple(binding.get(word, word) for word in a.split()) for a in ATOM.findall(condition)]
        assert set(put) <= state, line
        gone = re.findall(r"\(not \(([^()]+)\)\)", effect)
        come = ATOM.findall(re.sub(r"\(not \([^()]+\)\)", "", effect))
        state -= {tuple(binding.get(word, word) for word in a.split()) for a in gone}
        state |= {tuple(binding.get(word, word) for word in a.split()) for a in come}
    assert {tuple(a.split()) for a in ATOM.findall(task.partition("(:goal")[2])} <= state


def test_exports_of_chains_grow_with_their_lengths() -> None:
    """Not with the number of chains that modules could form, which is some 10,000 times as large for eight as for
    four."""
    path = str(Path(__file__).parents[2] / "examples" / "chain_climb.tamp")
    sizes = []
    for modules in ("4", "8"):
        problem, _ = compile_problem(path, "chain_climb", {"modules": modules})
        sizes.append(sum(map(len, to_pddl(problem))))
    assert sizes[1] < 12 * sizes[0]


@pytest.mark.parametrize("name", variants.PROBLEMS)
def test_what_pddl_cannot_say_is_told_to_the_user(name: str) -> None:
    try:
        domain, _ = to_pddl(variants.PROBLEMS[name]())
    except UsageError as error:
        assert "PDDL" in str(error)
    else:
        assert domain.startswith("(define")


RESERVED = """define domain problem requirements types constants objects predicates functions action parameters
precondition
effect init goal metric and or not imply exists forall when either assign increase decrease minimize maximize object
number over at start end all always sometime within preference durative-action duration condition derived"""
AWKWARD = """
type thing < object
predicate (reached X: thing)
predicate (not_reached X: thing)
predicate (define X: thing) functional in X
rule reach(X x: thing) { pre not (reached X) post (reached X), (not_reached x) }
rule either(imply: thing) { post not (reached imply), (define imply) }
task problem() {
    for i in 1 .. 2 { thing either[i]: sphere(1 cm) at (i * 1 m, 0, 0) }
    thing either_1: sphere(1 cm) at (0, 1 m, 0)
    thing Either_1: sphere(1 cm) at (0, 2 m, 0)
    thing nothing: sphere(1 cm) at (0, 3 m, 0)
    thing _9: sphere(1 cm) at (0, 4 m, 0)
    thing LONG: sphere(1 cm) at (0, 5 m, 0)
    goal (reached nothing), (not_reached LONG)
}
""".replace("LONG", "l" * 250)


def test_names_are_read_by_every_reader_and_told_in_comments() -> None:
    problem, _ = compile_text(AWKWARD)
    domain, task = to_pddl(problem)
    told = dict(re.findall(r"^; (\w+): (.+)$", domain, re.MULTILINE))
    assert sorted(told.values()) == sorted([*problem.objects, *problem.predicates])
    text = re.sub(r";.*", "", domain) + task
    names = set(re.findall(r"[^\s()?:]+", text)) - {"-"}
    for name in names - set(RESERVED.split()) - {"strips", "typing"}:
        assert re.fullmatch(r"[a-z][a-z0-9_]{0,70}", name), name
    assert not set(RESERVED.split()) & {*told, *re.findall(r":action (\S+)", domain), *re.findall(r"\?(\S+)", text)}
    for parameters, _, _ in actions(domain):
        names_ = re.findall(r"\?\w+", parameters)
        assert len(names_) == len(set(names_))
    assert shortest(domain, task, 3) == 1
    assert to_pddl(problem) == (domain, task)


SECOND = """
type thing < object
predicate (at X: thing, A: thing) functional in A
rule move(A X: thing) { post (at X A) }
rule wipe(A: thing) { post not (at ANY A) }
rule swap(A X: thing) { pre (at X A) post not (at X A), (at A A) }
task t() {
    thing a: box(1 m, 1 m, 1 m) at (0, 0, 0)
    thing b: box(1 m, 1 m, 1 m) at (3 m, 0, 0)
    fact (at a a)
    goal GOAL
}
"""


@pytest.mark.parametrize(("goal", "length"), [("(at b a)", 2), ("(at b b)", 1), ("(at a b), (at a a)", 1)])
def test_functional_predicates_have_one_value(goal: str, length: int) -> None:
    problem, _ = compile_text(SECOND.replace("GOAL", goal))
    candidate = SkeletonSearch(problem, Successors(problem), "astar", Budget(20)).next()
    assert candidate is not None and len(candidate.actions) == length
    assert shortest(*to_pddl(problem), 4) == length
