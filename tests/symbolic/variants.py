"""What the standard rules do not use: conditional effects, loops, disjunctions, wildcards, loose facts."""

from __future__ import annotations

from collections.abc import Callable

from tamplang.compiler.ir import (
    And,
    ChainModule,
    Compare,
    EffectFor,
    EffectIf,
    Exists,
    Forall,
    Formula,
    Not,
    Number,
    Object,
    ObjectType,
    Or,
    Predicate,
    Problem,
    RangeType,
    Rule,
    Var,
    Variable,
)

from .problems import (
    BASE,
    CHAIN,
    EFFECTOR,
    OBJECT,
    ONE,
    at_most,
    box,
    call,
    lit,
    module,
    no,
    post,
    problem,
    term,
    variables,
)

MODULE = ObjectType("module")


def rule(name: str, parameters: tuple[Variable, ...], condition: Formula, *effects: object) -> Rule:
    return Rule(name, parameters, condition, post(*effects), ONE)


def table(
    rules: list[Rule], extra: list[Predicate], facts: set[tuple[str, ...]], goal: Formula, count: int = 2
) -> Problem:
    bodies = [box("plate", "base", (1, 1, 0.1), (0, 0, 0)), box("shelf", "base", (1, 1, 0.1), (1.4, 0, 0))]
    bodies += [box(f"cup[{i}]", "object", (0.1, 0.1, 0.1), (0.2 * i, 0, 0.1), True) for i in range(1, 4)]
    modules = [module(f"m[{k}]", 0, 0.3 * k, 0.05) for k in range(1, count + 1)]
    return problem(bodies, modules, facts, goal, {r.name: r for r in rules}, {p.name: p for p in extra})


def loose_facts() -> Problem:
    """Facts of large objects without a field, conditional effects on them, wildcards on both sides."""
    dirty = Predicate("dirty", variables(OBJECT, "X"), False, False, None)
    near = Predicate("near", variables(OBJECT, "X", "Y"), False, True, None)
    rules = [
        rule("wash", variables(OBJECT, "X"), lit("dirty", "X"), no("dirty", "X")),
        rule(
            "spill", variables(OBJECT, "X"), And((lit("grippable", "X"), no("dirty", "X"))),
            lit("dirty", "X"),
            EffectFor(variables(OBJECT, "Y"), (EffectIf(lit("near", "X", "Y"), post(lit("dirty", "Y"))),)),
        ),
        rule("gather", variables(OBJECT, "X", "Y"),
             And((lit("grippable", "X"), lit("grippable", "Y"), Compare("!=", Var("X"), Var("Y")))),
             lit("near", "X", "Y")),
        rule("scatter", variables(OBJECT, "X"), Exists(variables(OBJECT, "Y"), lit("near", "X", "Y")),
             no("near", "X", "ANY")),
        rule("shine", variables(OBJECT, "X"),
             And((lit("grippable", "X"), Forall(variables(OBJECT, "Y"), Or((no("near", "X", "Y"), no("dirty", "Y")))))),
             EffectIf(lit("dirty", "X"), post(no("dirty", "ANY"))),
             EffectIf(no("dirty", "X"), post(lit("near", "X", Object("plate"))))),
    ]
    facts = {("grippable", f"cup[{i}]") for i in range(1, 4)} | {("dirty", "cup[1]")}
    return table(rules, [dirty, near], facts, Forall(variables(OBJECT, "X"), no("dirty", "X")), 1)


def fields() -> Problem:
    """Functional predicates read and written through values, keys and conditions."""
    slot = Predicate("slot", variables(OBJECT, "X", "Y"), False, False, 0)
    rules = [
        rule("put", variables(OBJECT, "X", "Y"), And((lit("grippable", "X"), lit("tray", "Y"))), lit("slot", "X", "Y")),
        rule("drop", variables(OBJECT, "X"), Exists(variables(OBJECT, "Y"), lit("slot", "X", "Y")),
             no("slot", "X", "ANY")),
        rule("swap", variables(OBJECT, "X", "Y", "U", "V"),
             And((lit("slot", "X", "U"), lit("slot", "Y", "V"), Compare("!=", Var("U"), Var("V")))),
             no("slot", "X", "U"), no("slot", "Y", "V"), lit("slot", "X", "V"), lit("slot", "Y", "U")),
        rule("clear", variables(OBJECT, "Y"), And((lit("tray", "Y"), Or((lit("slot", Object("cup[1]"), "Y"),
             lit("slot", Object("cup[2]"), "Y"))))), no("slot", "ANY", "Y")),
        rule("take", variables(EFFECTOR, "A") + variables(OBJECT, "X"),
             And((lit("grippable", "X"), Not(Exists(variables(OBJECT, "Z"), lit("grasped", "A", "Z"))))),
             lit("grasped", "A", "X"), no("slot", "X", Object("shelf"))),
        rule("give", variables(EFFECTOR, "A", "B") + variables(OBJECT, "X"),
             And((lit("grasped", "A", "X"), Compare("!=", Var("A"), Var("B")))),
             EffectIf(Exists(variables(OBJECT, "Z"), lit("grasped", "B", "Z")), post(no("grasped", "B", "ANY"))),
             no("grasped", "A", "X"), lit("grasped", "B", "X")),
        rule("free", variables(OBJECT, "X"), And((lit("grippable", "X"), lit("held", "X"))), no("grasped", "ANY", "X")),
    ]
    facts = {("grippable", f"cup[{i}]") for i in range(1, 4)} | {("tray", "plate"), ("tray", "shelf")}
    facts.add(("slot", "cup[1]", "shelf"))
    goal = Or((lit("held", Object("cup[3]")), lit("slot", Object("cup[3]"), Object("plate"))))
    return table(rules, [slot], facts, goal, 1)


def chains() -> Problem:
    """Chains that join and part anywhere, ranges, aggregates of chains in goals, effects on whole modules."""
    tired = Predicate("tired", variables(MODULE, "M"), False, False, None)
    docked = Predicate("docked", variables(EFFECTOR, "A", "B"), False, False, 0)
    k = Var("k")
    length = call("length", "c")
    part = Rule(
        "part", (*variables(CHAIN, "c"), Variable("k", RangeType(Number(2.0), length))),
        at_most(length, Number(3.0)),
        post(no("connected", _at("c", k, "in"), "ANY"), lit("tired", _at("c", k, "")),
             EffectFor((Variable("i", RangeType(ONE, length)),), (
                 EffectIf(no("tired", _at("c", Var("i"), "")), post(lit("docked", "c.first", "c.last"))),
             ))),
        ONE,
    )
    rules = [
        rule("join", variables(CHAIN, "p", "q"), And((Compare("!=", term("p.last"), term("q.first")),
             Compare("!=", term("p.first"), term("q.first")))), lit("connected", "p.last", "q.first")),
        part,
        rule("rest", variables(MODULE, "M"), lit("tired", "M"), no("tired", "M")),
        rule("undock", variables(EFFECTOR, "A", "B"), lit("docked", "A", "B"), no("docked", "ANY", "B")),
    ]
    goal = Exists(variables(CHAIN, "c"), Compare(">=", call("length", "c"), Number(3.0)))
    return table(rules, [tired, docked], set(), goal, 3)


def _at(chain: str, index: Var, side: str) -> ChainModule:
    return ChainModule(chain, index, side)


def mixed() -> Problem:
    """A predicate that holds between effectors and between effectors and bodies; guards with arithmetic."""
    tied = Predicate("tied", variables(OBJECT, "X", "Y"), False, True, None)
    rules = [
        rule("tie", variables(EFFECTOR, "A") + variables(OBJECT, "X"),
             And((at_most(call("distance", "A", "X"), Number(1.0)), Compare("!=", Var("A"), Var("X")))),
             lit("tied", "A", "X")),
        rule("untie", variables(EFFECTOR, "A") + variables(OBJECT, "X"),
             And((lit("tied", "X", "A"), Not(Exists(variables(BASE, "Y"), lit("tied", "A", "Y"))))),
             no("tied", "A", "X")),
        rule("cut", variables(BASE, "Y"), Exists(variables(OBJECT, "X"), And((lit("tied", "X", "Y"),
             Compare("<", call("distance", "X", "Y"), Number(0.5))))), no("tied", "Y", "ANY")),
    ]
    return table(rules, [tied], set(), lit("tied", Object("m[1].A"), Object("shelf")), 1)


PROBLEMS: dict[str, Callable[[], Problem]] = {
    "loose facts": loose_facts,
    "fields": fields,
    "chains": chains,
    "mixed": mixed,
}
