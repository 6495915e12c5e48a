"""Small problems built by hand from the IR: the standard rules, a staircase, a table with items."""

from __future__ import annotations

import math
import random
from collections.abc import Iterable, Sequence
from typing import Any

from tamplang.compiler.ir import (
    And,
    Any_,
    Arith,
    Body,
    ChainEnd,
    ChainModule,
    ChainType,
    Compare,
    Derived,
    Effect,
    EffectFor,
    EffectItem,
    Effector,
    Exists,
    Fact,
    Formula,
    Function,
    Heuristic,
    Joint,
    Link,
    Literal,
    Module,
    ModuleType,
    MotionPredicate,
    Not,
    Number,
    Object,
    ObjectType,
    Options,
    Predicate,
    Problem,
    RangeType,
    Rule,
    Shape,
    Term,
    Var,
    Variable,
    World,
)

OBJECT, EFFECTOR, BASE = ObjectType("object"), ObjectType("effector"), ObjectType("base")
CHAIN = ChainType("module", "connected")
ONE = Number(1.0)


def variables(kind: ObjectType | ChainType | RangeType, *names: str) -> tuple[Variable, ...]:
    return tuple(Variable(n, kind) for n in names)


def term(item: Any) -> Term:
    if isinstance(item, str):
        if item == "ANY":
            return Any_()
        chain, dot, end = item.partition(".")
        if dot:
            return ChainEnd(chain, end == "last")
        return Var(item)
    made: Term = Number(float(item)) if isinstance(item, int | float) else item
    return made


def lit(predicate: str, *args: Any) -> Literal:
    return Literal(predicate, tuple(term(a) for a in args))


def motion(predicate: str, *args: Any) -> Literal:
    return Literal(predicate, tuple(term(a) for a in args), motion=True)


def call(name: str, *args: Any) -> Function:
    return Function(name, tuple(term(a) for a in args))


def at_most(left: Term, right: Term) -> Compare:
    return Compare("<=", left, right)


def plus(*terms: Term) -> Term:
    total = terms[0]
    for t in terms[1:]:
        total = Arith("+", (total, t))
    return total


def post(*items: Any) -> tuple[EffectItem, ...]:
    """Literals are added, `Not(literal)` deleted, other effect items pass."""
    made: list[EffectItem] = []
    for item in items:
        if isinstance(item, Literal):
            made.append(Effect(item, False))
        elif isinstance(item, Not):
            assert isinstance(item.operand, Literal)
            made.append(Effect(item.operand, True))
        else:
            made.append(item)
    return tuple(made)


def no(*args: Any) -> Not:
    return Not(lit(*args))


def no_motion(*args: Any) -> Not:
    return Not(motion(*args))


def module_of(k: int | Term, side: str) -> ChainModule:
    return ChainModule("c", term(k), side)


def standard_rules() -> dict[str, Rule]:
    k, i = Var("k"), Var("i")
    after_k, after_i = Arith("+", (k, ONE)), Arith("+", (i, ONE))
    step = Rule(
        "step",
        variables(EFFECTOR, "A", "B") + variables(BASE, "X", "Y"),
        And((
            lit("support", "A"), lit("linked", "A", "B"), lit("free", "B"), lit("on", "X", "A"),
            Not(Exists(variables(EFFECTOR, "C"), lit("connected", "A", "C"))),
            at_most(call("stride", "X", "Y", 0.03), call("reach", "A", "B")),
        )),
        post(
            no("support", "A"), no("on", "X", "A"), no_motion("stable", "ANY", "A"), no_motion("stand", "A", "X"),
            lit("support", "B"), lit("on", "Y", "B"), motion("stable", "Y", "B"), motion("stand", "B", "Y"),
        ),
        ONE,
    )
    grasp = Rule(
        "grasp",
        variables(EFFECTOR, "A") + variables(OBJECT, "X"),
        And((lit("free", "A"), lit("grippable", "X"), no("held", "X"), lit("reachable", "A", "X"))),
        post(
            no_motion("stable", "ANY", "X"), no("on", "ANY", "X"), no_motion("rest", "X", "ANY"),
            lit("grasped", "A", "X"), motion("stable", "A", "X"), motion("touch", "A", "X"),
        ),
        ONE,
    )
    place = Rule(
        "place",
        variables(EFFECTOR, "A") + variables(OBJECT, "X", "Y"),
        And((lit("grasped", "A", "X"), lit("tray", "Y"), lit("reachable", "A", "Y"))),
        post(
            no("grasped", "A", "X"), no_motion("stable", "A", "X"), no_motion("touch", "A", "X"),
            lit("on", "Y", "X"), motion("stable", "Y", "X"), motion("rest", "X", "Y"), motion("above", "X", "Y"),
        ),
        ONE,
    )
    radii = Arith("*", (Number(2.0), plus(call("radius", "p.first"), call("radius", "p.last"))))
    connect = Rule(
        "connect",
        variables(CHAIN, "p", "q"),
        And((
            lit("support", "p.first"), lit("free", "p.last"), lit("free", "q.first"), lit("support", "q.last"),
            Compare("!=", term("p.last"), term("q.first")),
            Exists(variables(OBJECT, "X", "Y"), And((
                lit("on", "X", "p.first"), lit("on", "Y", "q.last"),
                at_most(call("distance", "X", "Y"), plus(call("reach", "p"), call("reach", "q"), radii)),
            ))),
        )),
        post(
            no("support", "p.first"), no("on", "ANY", "p.first"), no_motion("stable", "ANY", "p.first"),
            no_motion("stand", "p.first", "ANY"), lit("connected", "p.last", "q.first"),
            motion("stable", "q.first", "p.last"), motion("connectCrawlers", "q.first", "p.last"),
        ),
        ONE,
    )
    last = Arith("-", (call("length", "c"), ONE))
    disconnect = Rule(
        "disconnect",
        variables(CHAIN, "c") + variables(RangeType(ONE, last), "k") + variables(BASE, "X"),
        And((
            lit("support", "c.last"), lit("free", "c.first"),
            Exists(variables(OBJECT, "Y"), And((
                lit("on", "Y", "c.last"), at_most(call("stride", "Y", "X", 0.03), call("reach", "c")),
            ))),
        )),
        post(
            lit("support", "c.first"), lit("on", "X", "c.first"), motion("stable", "X", "c.first"),
            motion("stand", "c.first", "X"), no("connected", module_of(k, "out"), module_of(after_k, "in")),
            no_motion("stable", module_of(k, "out"), module_of(after_k, "in")),
            no_motion("stable", module_of(after_k, "in"), module_of(k, "out")),
            no_motion("connectCrawlers", module_of(k, "out"), module_of(after_k, "in")),
            no_motion("connectCrawlers", module_of(after_k, "in"), module_of(k, "out")),
        ),
        ONE,
    )
    together = Rule(
        "stepTogether",
        variables(CHAIN, "c") + variables(BASE, "X", "Y"),
        And((
            lit("support", "c.first"), lit("free", "c.last"), lit("on", "X", "c.first"),
            Compare(">=", call("length", "c"), Number(2.0)),
            at_most(call("stride", "X", "Y", 0.03), call("reach", "c")),
        )),
        post(
            no("support", "c.first"), no("on", "X", "c.first"), no_motion("stable", "ANY", "c.first"),
            no_motion("stand", "c.first", "X"), lit("support", "c.last"), lit("on", "Y", "c.last"),
            motion("stable", "Y", "c.last"), motion("stand", "c.last", "Y"),
            EffectFor(variables(RangeType(ONE, last), "i"), post(
                no_motion("stable", module_of(i, "out"), module_of(after_i, "in")),
                motion("stable", module_of(after_i, "in"), module_of(i, "out")),
            )),
        ),
        ONE,
    )
    return {r.name: r for r in (step, grasp, place, connect, disconnect, together)}


def standard_predicates() -> dict[str, Predicate]:
    made = [
        Predicate("linked", variables(EFFECTOR, "A", "B"), True, True, None),
        Predicate("grippable", variables(OBJECT, "X"), True, False, None),
        Predicate("tray", variables(OBJECT, "Y"), True, False, None),
        Predicate("support", variables(EFFECTOR, "A"), False, False, None),
        Predicate("on", variables(OBJECT, "X", "A"), False, False, 1),
        Predicate("grasped", variables(EFFECTOR, "A") + variables(OBJECT, "X"), False, False, 0),
        Predicate("connected", variables(EFFECTOR, "A", "B"), False, True, None),
    ]
    return {p.name: p for p in made}


def standard_derived() -> dict[str, Derived]:
    held = Derived("held", variables(OBJECT, "X"), Exists(variables(EFFECTOR, "A"), lit("grasped", "A", "X")))
    free = Derived("free", variables(EFFECTOR, "A"), And((
        no("support", "A"),
        Not(Exists(variables(OBJECT, "X"), lit("grasped", "A", "X"))),
        Not(Exists(variables(EFFECTOR, "B"), lit("connected", "A", "B"))),
    )))
    radii = plus(call("reach", "c"), call("radius", "c.first"), call("radius", "c.last"))
    reachable = Derived(
        "reachable",
        variables(EFFECTOR, "A") + variables(OBJECT, "X"),
        Exists(variables(CHAIN, "c") + variables(OBJECT, "Y"), And((
            Compare("=", term("c.last"), Var("A")), lit("support", "c.first"), lit("on", "Y", "c.first"),
            at_most(call("distance", "Y", "X"), radii),
        ))),
    )
    return {d.name: d for d in (held, free, reachable)}


def crawler() -> ModuleType:
    heights = [0, 0.15, 0.325, 0.5, 0.675, 0.85, 1.0]
    joints, links = [], []
    for i, (z, axis) in enumerate(zip(heights, "zyzyzyz", strict=True)):
        rise = z - (heights[i - 1] if i else 0)
        direction = (0.0, 0.0, 1.0) if axis == "z" else (0.0, 1.0, 0.0)
        joints.append(Joint(f"j{i + 1}", "revolute", i - 1, (0, 0, rise, 0, 0, 0, 1), direction, -2.1, 2.1, 0.0, 2.0))
        if i:
            links.append(Link(i - 1, (0, 0, rise / 2, 0, 0, 0, 1), Shape("capsule", (0.04, rise))))
    ends = (
        Effector("A", "gripper", -1, (0, 0, 0, 1, 0, 0, 0), Shape("sphere", (0.05,))),
        Effector("B", "gripper", 6, (0, 0, 0, 0, 0, 0, 1), Shape("sphere", (0.05,))),
    )
    return ModuleType("crawler", tuple(joints), ends, tuple(links))


CRAWLER = crawler()


def module(name: str, x: float, y: float, top: float) -> Module:
    return Module(name, CRAWLER, (x, y, top + 0.05, 0, 0, 0, 1), tuple(j.home for j in CRAWLER.joints))


def box(name: str, kind: str, size: Sequence[float], at: Sequence[float], movable: bool = False) -> Body:
    return Body(name, kind, Shape("box", tuple(size)), (at[0], at[1], at[2], 0, 0, 0, 1), movable)


def problem(
    bodies: Iterable[Body],
    modules: Iterable[Module],
    facts: Iterable[Fact],
    goal: Formula,
    rules: dict[str, Rule] | None = None,
    predicates: dict[str, Predicate] | None = None,
    heuristic: Heuristic | None = None,
    motions: dict[str, MotionPredicate] | None = None,
) -> Problem:
    bodies, modules = list(bodies), list(modules)
    types = {
        "object": None, "effector": "object", "module": None, "base": "object", "gripper": "effector",
        "crawler": "module",
    }
    objects = {b.name: b.type for b in bodies} | {m.name: m.type.name for m in modules}
    objects |= {f"{m.name}.{e.name}": e.type for m in modules for e in m.type.effectors}
    init = set(facts) | {("linked", f"{m.name}.A", f"{m.name}.B") for m in modules}
    table = standard_predicates() | (predicates or {})
    init |= {(f[0], f[2], f[1]) for f in init if table[f[0]].symmetric}
    world = World({m.name: m for m in modules}, {b.name: b for b in bodies})
    stable = MotionPredicate("stable", variables(OBJECT, "X", "Y"), False, ())
    touch = MotionPredicate("touch", variables(OBJECT, "X", "Y"), True, ())
    return Problem(
        "task", "task.tamp", 0, {}, types, objects, table, standard_derived(),
        motions or {"stable": stable, "touch": touch}, rules if rules is not None else standard_rules(), heuristic,
        frozenset(init), _start_motion(init), goal, world, Options(), (),
    )


def _start_motion(init: set[Fact]) -> frozenset[Fact]:
    on = {f for f in init if f[0] == "on"}
    stands = {("stand", a, x) for _, x, a in on if ("support", a) in init}
    return frozenset({("stable", x, a) for _, x, a in on} | stands)


def climb(
    stairs: int, crawlers: int, seed: int = 0, goal: Formula | None = None, rise: float = 1.0, jitter: float = 0.03
) -> Problem:
    """A staircase; every crawler stands on the ground; the target hangs above the top."""
    chance = random.Random(seed)

    def moved() -> float:
        return chance.uniform(-jitter, jitter)

    bodies = [box("ground", "base", (2, 2, 0.05), (-0.9, 0, 0))]
    for i in range(1, stairs + 1):
        bodies.append(box(f"stair[{i}]", "base", (0.3, 0.8, 0.05), (0.35 * i + moved(), 0, 0.2 * i + moved())))
    height = 0.2 * stairs + rise
    bodies.append(Body("target", "object", Shape("sphere", (0.04,)), (0.35 * stairs, 0, height, 0, 0, 0, 1), True))
    modules = [module(f"c[{k}]", -0.2, 0.35 * (k - (crawlers + 1) / 2), 0.025) for k in range(1, crawlers + 1)]
    facts: set[Fact] = {("grippable", "target")}
    for m in modules:
        facts |= {("support", f"{m.name}.A"), ("on", "ground", f"{m.name}.A")}
    return problem(bodies, modules, facts, goal or lit("held", Object("target")))


def pick_and_place(items: int, trays: int = 1) -> Problem:
    """A crawler on a pedestal, items on a table, trays around it."""
    bodies = [
        box("pedestal", "base", (0.3, 0.3, 0.05), (0, 0, 0)),
        box("table", "object", (0.4, 1.4, 0.04), (0.55, 0, 0.02)),
    ]
    facts: set[Fact] = {("support", "c.A"), ("on", "pedestal", "c.A")}
    for k in range(1, trays + 1):
        bodies.append(box(f"tray[{k}]", "object", (0.3, 0.3, 0.04), (0, -0.6 * math.cos(k), 0.02)))
        facts.add(("tray", f"tray[{k}]"))
    for i in range(1, items + 1):
        y = 0.15 * (i - (items + 1) / 2) if items < 10 else 0.01 * i
        bodies.append(box(f"item[{i}]", "object", (0.06, 0.06, 0.06), (0.55, y, 0.07), True))
        facts |= {("on", "table", f"item[{i}]"), ("grippable", f"item[{i}]")}
    goal = And(tuple(lit("on", Object("tray[1]"), Object(f"item[{i}]")) for i in range(1, items + 1)))
    return problem(bodies, [module("c", 0, 0, 0.025)], facts, goal)
