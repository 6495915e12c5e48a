"""PDDL becomes programs that check, whose cheapest plans cost what Fast Downward found; what is wrong is told."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import tamplang
from benchmarks.imports.domains import DOMAINS

from .conftest import Command, problems, refused

OPTIMAL = {
    ("blocks", 5): 10, ("gripper", 3): 9, ("hanoi", 4): 15, ("logistics", 3): 23, ("ferry", 4): 14, ("lift", 3): 7,
    ("satellite", 3): 9, ("transport", 3): 30, ("briefcase", 5): 14, ("visit-all", 3): 8, ("lights", 4): 2,
    ("puzzle", 10): 4, ("workshop", 2): 24,
}  # fmt: skip
"""What Fast Downward (A* with LM-cut, or blind where conditions depend) says of the instances: `tamplang bench imports`
asks it again for all of them."""


@pytest.mark.parametrize(("name", "size"), OPTIMAL, ids=str)
def test_plans_cost_what_an_optimal_planner_says(command: Command, name: str, size: int) -> None:
    domain, make, _ = DOMAINS[name]
    Path("d.pddl").write_text(domain)
    Path("p.pddl").write_text(make(size, 1))
    answer = command("import", "p.pddl", "d.pddl", "-o", "task.tamp")
    assert answer.status == 0, answer.told
    assert not [code for code in problems(command, "task.tamp") if code.startswith("E")]
    assert command("fmt", "--check", "task.tamp").status == 0
    result = tamplang.load("task.tamp").solve(time=100.0)
    assert result.status == "solved" and result.cost == OPTIMAL[name, size]


DOMAIN = """(define (domain house)
  (:requirements :adl :derived-predicates :action-costs)
  (:types room - place  box place)
  (:constants cellar - room)
  (:predicates (at ?b - box ?r - room) (open ?r - place) (heavy ?b - box) (full ?r - room))
  (:functions (total-cost) - number (way ?a ?b - room) - number)
  (:derived (full ?r - room) (exists (?b - box) (at ?b ?r)))
  (:action carry :parameters (?b - box ?from ?to - room)
    :precondition (and (at ?b ?from) (or (open ?to) (= ?to cellar)) (imply (heavy ?b) (= ?to cellar)))
    :effect (and (not (at ?b ?from)) (at ?b ?to) (increase (total-cost) (way ?from ?to))))
  (:action unlock :parameters (?r - room)
    :precondition (not (open ?r))
    :effect (and (open ?r) (increase (total-cost) 0.5)
      (forall (?x - room) (when (and (not (= ?x ?r)) (open ?x)) (not (open ?x)))))))
"""
PROBLEM = """(define (problem move-in) (:domain house)
  (:objects a b - box hall attic - room)
  (:init (at a hall) (at b hall) (heavy b) (= (total-cost) 0)
    (= (way hall attic) 2) (= (way hall cellar) 3) (= (way attic cellar) 1))
  (:goal (and (full attic) (full cellar) (not (full hall)) (exists (?r - room) (not (open ?r)))))
  (:metric minimize (total-cost)))
"""


def imported(command: Command, domain: str, problem: str) -> str:
    Path("d.pddl").write_text(domain)
    Path("p.pddl").write_text(problem)
    answer = command("import", "d.pddl", "p.pddl", "-o", "task.tamp")
    assert answer.status == 0, answer.told
    return Path("task.tamp").read_text()


def cost(command: Command, domain: str, problem: str) -> float | None:
    imported(command, domain, problem)
    result = tamplang.load("task.tamp").solve(time=60.0)
    return result.cost if result.status == "solved" else None


def test_everything_at_once(command: Command) -> None:
    """Unlock the attic, carry a there and b, which is heavy, to the cellar."""
    assert cost(command, DOMAIN, PROBLEM) == 0.5 + 2 + 3


def test_variables_need_no_blank_before_them(command: Command) -> None:
    assert cost(command, re.sub(r" \?", "?", DOMAIN), PROBLEM) == cost(command, DOMAIN, PROBLEM)


def test_a_value_that_is_not_stated_forbids_the_action(command: Command) -> None:
    without = PROBLEM.replace("(= (way hall cellar) 3)", "").replace("(heavy b)", "")
    assert cost(command, DOMAIN, without) == 0.5 + 2 + 2 + 1
    without = without.replace("(= (way attic cellar) 1)", "")
    imported(command, DOMAIN, without)
    assert "E0503" in problems(command, "task.tamp")


def test_without_a_metric_actions_count(command: Command) -> None:
    assert cost(command, DOMAIN, PROBLEM.replace("(:metric minimize (total-cost))", "")) == 3


def test_what_is_added_stays_although_it_is_deleted(command: Command) -> None:
    domain = """(define (domain d) (:predicates (p ?x) (q ?x)) (:action a :parameters (?x ?y)
        :precondition (p ?x) :effect (and (not (p ?x)) (p ?y) (p ?x) (q ?y)
        (forall (?z) (when (q ?z) (and (not (q ?z)) (q ?z)))))))"""
    problem = "(define (problem p) (:domain d) (:objects m n) (:init (p m)) (:goal (and (q n) (q m) (p m) (p n))))"
    assert cost(command, domain, problem) == 2


def test_many_different_costs(command: Command) -> None:
    """More than `if` could ask for one behind the other."""
    n = 150
    domain = """(define (domain d) (:types t) (:predicates (here ?x - t) (way ?x ?y - t))
        (:functions (total-cost) - number (price ?x ?y - t) - number) (:action go :parameters (?x ?y - t)
        :precondition (and (here ?x) (way ?x ?y))
        :effect (and (here ?y) (not (here ?x)) (increase (total-cost) (price ?x ?y)))))"""
    ways = " ".join(f"(way x{k} x{k + 1}) (= (price x{k} x{k + 1}) {k}.25)" for k in range(n))
    objects = " ".join(f"x{k}" for k in range(n + 1))
    problem = f"""(define (problem p) (:domain d) (:objects {objects} - t) (:init (here x146) {ways})
        (:goal (here x150)) (:metric minimize (total-cost)))"""
    assert cost(command, domain, problem) == 146 + 147 + 148 + 149 + 1


RESERVED = """and-1 or-1 object-1 exists-1 min max previous sum goal fact task rule module effector box sphere at on in
    import length first if-1 then else ANY not-1 scene options true robot x X"""


def test_every_name_can_be_imported(command: Command) -> None:
    """Words of this language, upper case, digits in front, and names that differ in signs only."""
    names = [*dict.fromkeys(RESERVED.lower().split()), "a-b", "a_b", "2go"]
    names.remove("x")
    predicates = " ".join(f"({n} ?{n} ?x - goal)" for n in names)
    actions = "\n".join(
        f"(:action {n} :parameters (?{n} ?x - goal) :precondition (not ({n} ?{n} ?x)) :effect ({n} ?{n} ?x))"
        for n in names
    )
    domain = f"(define (domain task) (:types goal) (:predicates {predicates}) {actions})"
    facts = " ".join(f"({n} 2go x)" for n in names)
    objects = f"{' '.join(names[:-3])} - object a-b a_b 2go x - goal"
    problem = f"(define (problem rule) (:domain task) (:objects {objects}) (:init {facts}) (:goal (A-B A-B 2GO)))"
    imported(command, domain, problem)
    assert not [code for code in problems(command, "task.tamp") if code.startswith("E")]
    assert tamplang.load("task.tamp").solve(time=100.0).cost == 1


def spoilt(text: str, old: str, new: str) -> str:
    assert old in text
    return text.replace(old, new, 1)


UNION = """(define (domain mix) (:requirements :adl :typing :derived-predicates)
  (:types car truck bike - vehicle vehicle place - object amphi - (either car truck))
  (:constants depot - place)
  (:predicates (at ?v - (either car truck bike) ?p - place) (road ?a ?b - place) (trail ?a ?b - place)
    (done ?v) (ready ?v - vehicle) (dirty ?v - vehicle))
  (:derived (ready ?v - (either car truck)) (and (at ?v depot) (not (dirty ?v))))
  (:derived (ready ?v - bike) (exists (?p - place) (and (at ?v ?p) (not (= ?p depot)))))
  (:action drive :parameters (?v - (either car truck) ?a ?b - place)
    :precondition (and (at ?v ?a) (road ?a ?b)) :effect (and (not (at ?v ?a)) (at ?v ?b)))
  (:action ride :parameters (?v - (either bike car) ?a ?b - place)
    :precondition (and (at ?v ?a) (trail ?a ?b)) :effect (and (not (at ?v ?a)) (at ?v ?b) (dirty ?v)))
  (:action wash :parameters (?p - place) :precondition (exists (?v - (either bike truck)) (at ?v ?p))
    :effect (forall (?v - (either car truck)) (when (at ?v ?p) (not (dirty ?v)))))
  (:action finish :precondition (forall (?v - (either car bike)) (ready ?v))
    :effect (forall (?v - (either truck bike)) (done ?v))))
"""
UNION_PROBLEM = """(define (problem some) (:domain mix)
  (:objects c - car t - truck b - bike m - amphi x - (either car truck) p q - place)
  (:init (at c p) (at t q) (at b p) (at m q) (at x p) (road p depot) (road depot p) (trail p q) (trail q p)
    (trail q depot) (road depot q) (trail depot q) (dirty m) (dirty c))
  (:goal GOAL))
"""


@pytest.mark.parametrize(("goal", "cost"), {
    "(at x q)": 2,  # it may be a truck: it does not ride, but drives by the depot
    "(and (not (dirty c)) (at c depot))": 2,  # washed where the bike is, for what is at p need not be a truck
    "(and (not (dirty m)) (at m q))": 1,  # what is either a car or a truck is one of (either car truck)
    "(and (done b) (done t))": 3,  # the car has to be ready, the bike is, and nobody asks for the others
    "(done m)": None,  # finishing needs a truck or a bike, and m may be neither
    "(at m p)": None,  # nor may it ride, and from q no road leaves
}.items(), ids=str)  # fmt: skip
def test_variables_objects_and_types_may_be_of_either_of_several_types(
    command: Command, goal: str, cost: int | None
) -> None:
    Path("d.pddl").write_text(UNION)
    Path("p.pddl").write_text(UNION_PROBLEM.replace("GOAL", goal))
    answer = command("import", "d.pddl", "p.pddl", "-o", "task.tamp")
    assert answer.status == 0, answer.told
    assert not [code for code in problems(command, "task.tamp") if code.startswith("E")]
    result = tamplang.load("task.tamp").solve(time=100.0)
    assert result.status == ("infeasible" if cost is None else "solved") and (cost is None or result.cost == cost)


def test_derived_predicates_reach_as_far_as_they_are_asked_for(command: Command) -> None:
    Path("d.pddl").write_text("""(define (domain w) (:requirements :adl :derived-predicates) (:types a b - o o)
      (:predicates (on ?x - o) (p ?x - a) (r ?x - a) (done))
      (:derived (r ?x - a) (p ?x))
      (:derived (p ?x - a) (on ?x))
      (:action go :parameters (?y - o) :precondition (r ?y) :effect (done))
      (:action turn :parameters (?y - o) :precondition (not (on ?y)) :effect (on ?y)))""")
    Path("p.pddl").write_text("(define (problem x) (:domain w) (:objects k - a l - b) (:init (on l)) (:goal (done)))")
    assert command("import", "d.pddl", "p.pddl", "-o", "task.tamp").status == 0
    assert not [code for code in problems(command, "task.tamp") if code.startswith("E")]
    assert tamplang.load("task.tamp").solve(time=100.0).cost == 2  # `l` is on, but no `a`


IN_DOMAIN = {
    "open bracket": ("(when (and (not (= ?x ?r)) (open ?x)) (not (open ?x)))))))", "(when (open ?x)", "E0019"),
    "closed twice": ("(open ?r) (increase", "(open ?r)) (increase", "E0019"),
    "no PDDL": ("(define (domain house)", "(describe (domain house)", "E0019"),
    "word outside": ("(define", "hello (define", "E0019"),
    "duration": (":adl", ":durative-actions", "E0020"),
    "unknown requirement": (":adl", ":adll", "E0022"),
    "unknown section": ("(:constants", "(:konstants", "E0022"),
    "durative action": ("(:action unlock", "(:durative-action unlock", "E0020"),
    "section twice": ("(:constants cellar - room)", "(:constants cellar - room) (:constants)", "E0022"),
    "type below itself": ("room - place", "room - place place - room", "E0022"),
    "type of two": ("room - place", "room - place room - box", "E0022"),
    "unknown type": ("?b - box ?r - room)", "?b - bx ?r - room)", "E0022"),
    "unknown type in either": ("?b - box ?from", "?b - (either box rom) ?from", "E0022"),
    "either of itself": ("room - place", "room - (either place box) box - room", "E0022"),
    "unknown predicate": ("(and (at ?b ?from)", "(and (att ?b ?from)", "E0022"),
    "arity": ("(and (at ?b ?from)", "(and (at ?b)", "E0022"),
    "unknown variable": ("(and (at ?b ?from)", "(and (at ?c ?from)", "E0022"),
    "unknown constant": ("(= ?to cellar))", "(= ?to celar))", "E0022"),
    "number in a condition": ("(and (at ?b ?from)", "(and (> (way ?from ?to) 3)", "E0020"),
    "preference": ("(and (at ?b ?from)", "(and (preference p (at ?b ?from))", "E0020"),
    "other number": ("(increase (total-cost) 0.5)", "(decrease (total-cost) 0.5)", "E0020"),
    "cost that depends": ("(not (open ?x)))", "(increase (total-cost) 1))", "E0020"),
    "unknown function": ("(way ?from ?to))))", "(wy ?from ?to))))", "E0022"),
    "disjunctive effect": ("(and (not (at ?b ?from))", "(or (not (at ?b ?from))", "E0020"),
    "effect on a derived predicate": ("(at ?b ?to) (inc", "(full ?to) (inc", "E0022"),
    "recursive derived predicate": ("(exists (?b - box) (at ?b ?r))", "(exists (?x - room) (full ?x))", "E0020"),
    "action twice": ("(:action unlock", "(:action carry", "E0022"),
    "parameter twice": ("?from ?to - room)", "?from ?from - room)", "E0022"),
    "part without value": (":effect (and (not", ":effect :effect (and (not", "E0019"),
    "unknown part": (":precondition (not", ":precond (not", "E0022"),
    "no name": ("(:action unlock", "(:action", "E0019"),
    "parameter without ?": ("(?b - box ?from", "(b - box ?from", "E0019"),
}
IN_PROBLEM = {
    "other domain": ("(:domain house)", "(:domain hut)", "E0022"),
    "object twice": ("a b - box", "a a - box", "E0022"),
    "object like a constant": ("a b - box", "a cellar - box", "E0022"),
    "type missing": ("hall attic - room", "hall attic -", "E0019"),
    "unknown object": ("(heavy b)", "(heavy c)", "E0022"),
    "unknown fact": ("(heavy b)", "(havy b)", "E0022"),
    "derived fact": ("(heavy b)", "(full attic)", "E0022"),
    "timed fact": ("(heavy b)", "(at 5 (heavy b))", "E0020"),
    "negative cost": ("(= (way hall attic) 2)", "(= (way hall attic) -2)", "E0020"),
    "no number": ("(= (way hall attic) 2)", "(= (way hall attic) two)", "E0019"),
    "maximize": ("minimize (total-cost)", "maximize (total-cost)", "E0020"),
    "other metric": ("minimize (total-cost)", "minimize (total-time)", "E0020"),
    "no goal": ("(:goal (and (full attic) (full cellar) (not (full hall)) (exists (?r - room) (not (open ?r)))))", "",
                "E0022"),
    "empty goal": ("(:goal (and", "(:goal) (:length (and", "E0019"),
    "constraints": ("(:metric minimize (total-cost))", "(:constraints (always (open hall)))", "E0020"),
    "goal over time": ("(full attic)", "(sometime (full attic))", "E0020"),
    "cut off": ("(:metric minimize (total-cost)))", "(:metric", "E0019"),
}  # fmt: skip


@pytest.mark.parametrize("fault", IN_DOMAIN)
def test_mistakes_in_a_domain_are_told_with_their_place(command: Command, fault: str) -> None:
    old, new, code = IN_DOMAIN[fault]
    Path("d.pddl").write_text(spoilt(DOMAIN, old, new))
    Path("p.pddl").write_text(PROBLEM)
    told = refused(command, {code}, "d.pddl", "p.pddl")
    assert re.search(r"--> [dp]\.pddl:\d+:\d+", told), told


@pytest.mark.parametrize("fault", IN_PROBLEM)
def test_mistakes_in_a_problem_are_told_with_their_place(command: Command, fault: str) -> None:
    old, new, code = IN_PROBLEM[fault]
    Path("d.pddl").write_text(DOMAIN)
    Path("p.pddl").write_text(spoilt(PROBLEM, old, new))
    assert re.search(r"--> p\.pddl:\d+:\d+", refused(command, {code}, "d.pddl", "p.pddl"))


def test_all_mistakes_come_in_one_run(command: Command) -> None:
    domain = DOMAIN.replace("(heavy ?b) (=", "(hevy ?b) (=").replace("(not (open ?r))", "(not (opn ?r))")
    Path("d.pddl").write_text(domain)
    Path("p.pddl").write_text(PROBLEM.replace("(heavy b)", "(heavy c)"))
    told = refused(command, {"E0022"}, "d.pddl", "p.pddl")
    assert all(word in told for word in ("`hevy`", "`opn`", "`c`")) and "did you mean `heavy`?" in told


DEEP = "(define (domain d) (:action a :precondition " + "(not " * 5000 + "(p)" + ")" * 5000 + "))"


@pytest.mark.parametrize(
    ("content", "code"),
    [
        (b"", "E0013"), (b"\0\1\2", "E0014"), (b"hello", "E0019"), (b"{}", "E0019"), (b"<a/>", "E0019"),
        (DEEP.encode(), "E0019"), (b"(define (domain d)" + b";" * 1_100_000 + b"\n)", "E0015"),
        (b"(define (domain d)" + b"(" * 90, "E0019"), (PROBLEM.encode(), "E0021"), (b"(define (domain))", "E0019"),
        (b"(define (domain d)) (define (domain e))", "E0019"), (b"(define (domain d) x)", "E0019"),
    ],
)  # fmt: skip
def test_files_that_are_no_domain(command: Command, content: bytes, code: str) -> None:
    Path("d.pddl").write_bytes(content)
    Path("p.pddl").write_text(PROBLEM)
    refused(command, {code}, "d.pddl", "p.pddl")


def test_too_many_objects_are_refused(command: Command) -> None:
    Path("d.pddl").write_text("(define (domain d) (:predicates (p ?x)))")
    many = " ".join(f"o{k}" for k in range(10_001))
    Path("p.pddl").write_text(f"(define (problem p) (:domain d) (:objects {many}) (:init) (:goal (p o1)))")
    refused(command, {"E0510"}, "d.pddl", "p.pddl")


def test_one_file_of_two_and_files_that_are_not_there(command: Command) -> None:
    Path("d.pddl").write_text(DOMAIN)
    assert "a problem is needed" in refused(command, {"E0021"}, "d.pddl")
    refused(command, {"E0021"}, "d.pddl", "d.pddl")
    refused(command, {"E0010"}, "d.pddl", "q.pddl")
    refused(command, {"E0012"}, "d.pddl", ".")


def test_check_and_solve_say_which_command_reads_a_domain(command: Command) -> None:
    Path("d.pddl").write_text("; a comment\n" + DOMAIN)
    for name in ("check", "solve"):
        answer = command(name, "d.pddl")
        assert answer.status == 1 and "E0021" in answer.told and "tamplang import d.pddl" in answer.told


@pytest.mark.parametrize(("name", "size"), [("blocks", 4), ("gripper", 2), ("briefcase", 1), ("workshop", 1)], ids=str)
def test_plans_go_back_to_pddl(command: Command, name: str, size: int) -> None:
    """Every action of the exported plan may be done in the exported problem, whose goal holds at the end."""
    domain, make, _ = DOMAINS[name]
    imported(command, domain, make(size, 1))
    assert command("solve", "task.tamp", "--quiet", "--out", "a.plan.json").status == 0
    assert command("export", "a.plan.json", "--to", "pddl").status == 0
    assert command("export", "a.plan.json", "--to", "val").status == 0
    told, task = Path("a-domain.pddl").read_text(), Path("a.pddl").read_text()
    state = set(ATOM.findall(task.partition("(:init")[2].partition("(:goal")[0]))
    known = {a[0]: a[1:] for a in ACTION.findall(told)}
    lines = [line for line in Path("a.val").read_text().splitlines() if line.startswith("(")]
    assert lines
    for line in lines:
        action, *values = line.strip("()").split()
        parameters, condition, effect = known[action]
        binding = dict(zip(re.findall(r"\?\w+", parameters), values, strict=True))
        for variable, value in binding.items():
            condition, effect = (re.sub(re.escape(variable) + r"\b", value, text) for text in (condition, effect))
        assert state >= set(ATOM.findall(condition)), line
        gone = set(re.findall(r"\(not \(([^()]+)\)\)", effect))
        state = (state - gone) | set(ATOM.findall(re.sub(r"\(not \([^()]+\)\)", "", effect)))
    assert state >= set(ATOM.findall(task.partition("(:goal")[2]))


ATOM = re.compile(r"\(([^()]+)\)")
ACTION = re.compile(
    r"\(:action (\S+)\n    :parameters \((.*?)\)\n    :precondition (.*?)\n    :effect (.*?)(?=\n  \(:action|\n\)\n)",
    re.DOTALL,
)
