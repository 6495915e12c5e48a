"""Families of programs that grow: by nesting, doubling, chaining or width, over the constructs of the language.

A family makes the texts of one program from a size; `main.tamp` is the one that is given to a command. Where a program
has a task, it is named `t`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

MAIN = "main.tamp"
Texts = Mapping[str, str]
WORDS = """
type base < object
type foot < effector
predicate (at X: object)
predicate (open X: object)
derived (both X: object) = (at X) and (open X)
module arm(size: length = 1 m) {
    effector A: foot sphere(5 cm) normal (0, 0, -1)
    joint j: revolute(z) in -3 rad .. 3 rad
    link 0.5 * size: capsule(4 cm)
    effector B: foot sphere(5 cm)
}
motion [held X Y: object] { keep pose(Y, X) }
"""
"""What the programs below are made of."""


@dataclass(frozen=True, slots=True)
class Family:
    """`sizes` are those of the upper range, the largest last: what a size counts differs from family to family.

    `parts` says for how many things of the scene a program of a size stands, where that is not the size itself.
    """

    make: Callable[[int], Texts]
    sizes: tuple[int, ...]
    parts: Callable[[int], int] = lambda size: size


def _task(items: str, goal: str = "(at b)", rule: str = "") -> str:
    """A task over one body and one arm, which a rule can finish."""
    rule = rule or "rule go(X: base) { pre not (at X) post (at X) }"
    return f"""{rule}
task t() {{
    base g: box(1 m, 1 m, 5 cm) at (0, 0, 0)
    base b: box(20 cm, 20 cm, 5 cm) at (1 m, 0, 0)
    arm r: at (0, 0, 1 m)
    {items}
    goal {goal}
}}
"""


def _one(text: str) -> Texts:
    return {MAIN: WORDS + text}


def _lines(line: Callable[[int], str], count: int, start: int = 1) -> str:
    return "\n".join(line(i) for i in range(start, count + 1)) + "\n"


# --- doubling: each declaration uses the one before twice --------------------------------------------------------


def _twice(size: int) -> str:
    return "function f0(x: real) = x\n" + _lines(lambda i: f"function f{i}(x: real) = f{i - 1}(x) + f{i - 1}(x)", size)


def _doubled_functions(size: int) -> Texts:
    return _one(_twice(size))


def _doubled_arguments(size: int) -> Texts:
    body = _lines(lambda i: f"function f{i}(x: real) = f{i - 1}(x + x) * f{i - 1}(x)", size)
    return _one("function f0(x: real) = x\n" + body)


def _doubled_costs(size: int) -> Texts:
    rule = f"rule go(X Y: base) {{ pre not (at X) post (at X) cost d{size}(X, Y) / 1 m + 1 }}"
    body = "function d0(X Y: object) = distance(X, Y)\n"
    body += _lines(lambda i: f"function d{i}(X Y: object) = d{i - 1}(X, Y) + d{i - 1}(Y, X)", size)
    return _one(body + _task("", rule=rule))


def _doubled_guards(size: int) -> Texts:
    rule = f"rule go(X Y: base) {{ pre not (at X) where d{size}(X, Y) >= 0 m post (at X) }}"
    body = "function d0(X Y: object) = distance(X, Y)\n"
    body += _lines(lambda i: f"function d{i}(X Y: object) = d{i - 1}(X, Y) / 2 + d{i - 1}(Y, X)", size)
    return _one(body + _task("", rule=rule))


def _doubled_heuristics(size: int) -> Texts:
    body = "function d0(X Y: object) = distance(X, Y)\n"
    body += _lines(lambda i: f"function d{i}(X Y: object) = d{i - 1}(X, Y) + d{i - 1}(Y, X)", size)
    body += f"heuristic h(T: object) {{ start 1  go(X): d{size}(X, T) }}\n"
    return _one(body + _task("guide h(b)"))


def _doubled_conditions(size: int) -> Texts:
    body = "function d0(X: object) = if (at X) then 1 else 2\n"
    body += _lines(lambda i: f"function d{i}(X: object) = if d{i - 1}(X) > 1 then d{i - 1}(X) else 3", size)
    body += f"heuristic h(T: object) {{ start 1  go(X): d{size}(X) }}\n"
    return _one(body + _task("guide h(b)"))


def _doubled_derived(size: int) -> Texts:
    body = "derived (d0 X: object) = (at X)\n"
    body += _lines(lambda i: f"derived (d{i} X: object) = (d{i - 1} X) and not (d{i - 1} X) or (d{i - 1} X)", size)
    return _one(body + _task("", goal=f"(d{size} b)"))


def _doubled_quantifiers(size: int) -> Texts:
    body = "derived (d0 X: object) = (at X)\n"
    line = "derived (d{0} X: object) = exists Y: base {{ (d{1} Y) and not (d{1} X) }} or (d{1} X)"
    body += _lines(lambda i: line.format(i, i - 1), size)
    return _one(body + _task("", goal=f"(d{size} b)"))


def _doubled_rows(size: int) -> Texts:
    body = "function d0(X Y: object) = gap(X, Y)\n"
    body += _lines(lambda i: f"function d{i}(X Y: object) = gap(X, Y) + d{i - 1}(X, Y) + d{i - 1}(Y, X)", size)
    body += f"motion [near X Y: object] {{ at switch d{size}(X, Y) <= 1 m }}\n"
    rule = "rule go(X: base) { pre not (at X) post (at X), [near X X] }"
    return _one(body + _task("", rule=rule))


def _doubled_scenes(size: int) -> Texts:
    body = "scene s0(x: length) { }\n"
    body += _lines(lambda i: f"scene s{i}(x: length) {{ scene s{i - 1}(x) scene s{i - 1}(x + 1 m) }}", size)
    return _one(body + _task(f"scene s{size}(1 m)"))


def _doubled_parameters(size: int) -> Texts:
    body = _twice(size)
    return _one(body + _task(f"object o: box(1 cm, 1 cm, 1 cm) at (f{size}(0.0001), 3 m, 0)"))


# --- chaining: each uses the one before, or follows from it ------------------------------------------------------


def _chained_functions(size: int) -> Texts:
    body = "function f0(x: real) = x\n" + _lines(lambda i: f"function f{i}(x: real) = f{i - 1}(x) + 1", size)
    return _one(body + _task(f"object o: box(1 cm, 1 cm, 1 cm) at (f{size}(1) * 1 mm, 3 m, 0)"))


def _chained_derived(size: int) -> Texts:
    body = "derived (d0 X: object) = (at X)\n"
    body += _lines(lambda i: f"derived (d{i} X: object) = (d{i - 1} X) or (open X)", size)
    return _one(body + _task("", goal=f"(d{size} b)"))


def _chained_derived_backwards(size: int) -> Texts:
    body = "derived (d0 X: object) = (at X)\n"
    body += "\n".join(f"derived (d{i} X: object) = (d{i - 1} X) or (open X)" for i in range(size, 0, -1)) + "\n"
    return _one(body + _task("", goal=f"(d{size} b)"))


def _chained_types(size: int) -> Texts:
    body = "type t0 < base\n" + _lines(lambda i: f"type t{i} < t{i - 1}", size)
    items = f"t{size} o: box(1 cm, 1 cm, 1 cm) at (0, 3 m, 0)"
    return _one(body + _task(items))


def _chained_scenes(size: int) -> Texts:
    body = "scene s0() { object o: box(1 cm, 1 cm, 1 cm) at (0, 3 m, 0) }\n"
    body += _lines(lambda i: f"scene s{i}() {{ scene s{i - 1}() }}", size)
    return _one(body + _task(f"scene s{size}()"))


def _chained_rules(size: int) -> Texts:
    body = _lines(lambda i: f"predicate (p{i} X: object)", size, 0)
    body += _lines(lambda i: f"rule r{i}(X: base) {{ pre (p{i - 1} X) post (p{i} X), not (p{i - 1} X) }}", size)
    return _one(body + _task("fact (p0 b)", goal=f"(p{size} b)"))


def _chained_imports(size: int) -> Texts:
    texts = {f"f{i}.tamp": f'import "f{i + 1}.tamp"\ntype t{i} < object\n' for i in range(1, size)}
    texts[f"f{size}.tamp"] = f"type t{size} < object\n"
    return {MAIN: 'import "f1.tamp"\n' + WORDS + _task(""), **texts}


def _chained_bodies(size: int) -> Texts:
    body = "object o[0]: box(1 cm, 1 cm, 1 cm) on g at (0, 0)\n"
    body += _lines(lambda i: f"object o[{i}]: box(1 cm, 1 cm, 1 cm) on o[{i - 1}]", size)
    return _one(_task(body))


def _chained_sums(size: int) -> Texts:
    return _one(f"function f(x: real) = {' + '.join(['x'] * size)}\n" + _task(""))


def _chained_joints(size: int) -> Texts:
    body = _lines(lambda i: f"joint j{i}: revolute(y) in -1 rad .. 1 rad\nlink 1 mm: capsule(1 mm)", size)
    text = f"module long() {{ effector A: foot sphere(1 cm)\n{body}effector B: foot sphere(1 cm) }}\n"
    return _one(text + _task("long l: at (0, 3 m, 1 m)"))


# --- nesting -----------------------------------------------------------------------------------------------------


def _nested_groups(size: int) -> Texts:
    return _one(f"function f(x: real) = {'(' * size}x{')' * size}\n" + _task(""))


def _nested_minuses(size: int) -> Texts:
    return _one(f"function f(x: real) = {'-' * size}x\n" + _task(""))


def _nested_nots(size: int) -> Texts:
    return _one(f"derived (d X: object) = {'not ' * size}(at X)\n" + _task(""))


def _nested_quantifiers(size: int) -> Texts:
    heads = "".join(f"exists Y{i}: base {{ " for i in range(size))
    return _one(f"derived (d X: object) = {heads}(at X){' }' * size}\n" + _task(""))


def _nested_conditionals(size: int) -> Texts:
    heads = "".join(f"if x > {i} then {i} else " for i in range(size))
    return _one(f"function f(x: real) = {heads}0\n" + _task(""))


def _nested_calls(size: int) -> Texts:
    return _one(f"function f(x: real) = {'abs(' * size}x{')' * size}\n" + _task(""))


def _nested_loops(size: int) -> Texts:
    heads = "".join(f"for i{k} in 1 .. 2 {{ " for k in range(size))
    return _one(_task(f"{heads}fact (open b){' }' * size}"))


def _nested_branches(size: int) -> Texts:
    body = "branch { link 1 mm " * size + "}" * size
    return _one(f"module long() {{ effector A: foot sphere(1 cm)\n{body} }}\n" + _task(""))


# --- width -------------------------------------------------------------------------------------------------------


def _wide_conjunction(size: int) -> Texts:
    return _one(f"derived (d X: object) = {' and '.join(['(at X)'] * size)}\n" + _task("", goal="(d b)"))


def _wide_disjunction(size: int) -> Texts:
    body = " or ".join(["(at X)", "(open X)"] * (size // 2))
    return _one(f"derived (d X: object) = {body}\n" + _task("", goal="(d b)"))


def _wide_goal(size: int) -> Texts:
    return _one(_task("", goal=", ".join(["(at b)"] * size)))


def _wide_precondition(size: int) -> Texts:
    rule = f"rule go(X: base) {{ pre {', '.join(['not (at X)'] * size)} post (at X) }}"
    return _one(_task("", rule=rule))


def _wide_effects(size: int) -> Texts:
    rule = f"rule go(X: base) {{ pre not (at X) post {', '.join(['(at X)', '(open X)'] * (size // 2))} }}"
    return _one(_task("", rule=rule))


def _wide_rows(size: int) -> Texts:
    body = "at switch gap(X, Y) <= 1 m\n" * size
    rule = "rule go(X: base) { pre not (at X) post (at X), [near X X] }"
    return _one(f"motion [near X Y: object] {{ {body} }}\n" + _task("", rule=rule))


def _wide_facts(size: int) -> Texts:
    bodies = "object o: box(1 cm, 1 cm, 1 cm) at (0, 3 m, 0)\n"
    return _one(_task(bodies + "fact (open o)\n" * size))


def _wide_bodies(size: int) -> Texts:
    line = "object o[{0}]: box(1 cm, 1 cm, 1 cm) at (2 cm * {0}, 3 m, 0)\nfact (open o[{0}])"
    return _one(_task(_lines(lambda i: line.format(i), size)))


def _wide_loop(size: int) -> Texts:
    line = f"for i in 1 .. {size} {{ object o[i]: box(1 cm, 1 cm, 1 cm) at (2 cm * i, 3 m, 0) fact (open o[i]) }}"
    return _one(_task(line))


def _square_loop(size: int) -> Texts:
    loop = f"for i in 1 .. {size} {{ for j in 1 .. {size} {{ fact (open b) }} }}"
    return _one(_task(loop))


def _square_bodies(size: int) -> Texts:
    body = "object o[i, j]: box(1 cm, 1 cm, 1 cm) at (2 cm * i, 2 cm * j, 3 m)"
    body = body.replace("o[i, j]", "o[i][j]")
    return _one(_task(f"for i in 1 .. {size} {{ for j in 1 .. {size} {{ {body} }} }}"))


def _empty_loop(size: int) -> Texts:
    return _one(_task(f"for i in 1 .. {size} {{ for j in 1 .. {size} {{ if i < 0 {{ fact (open b) }} }} }}"))


def _square_goal(size: int) -> Texts:
    return _one(_task("", goal=f"forall i in 1 .. {size} {{ forall j in 1 .. {size} {{ (at b) or i > j }} }}"))


def _wide_motion_loop(size: int) -> Texts:
    body = f"for i in 1 .. {size} {{ at switch i * gap(X, Y) <= 1 m }}"
    rule = "rule go(X: base) { pre not (at X) post (at X), [near X X] }"
    return _one(f"motion [near X Y: object] {{ {body} }}\n" + _task("", rule=rule))


def _wide_sum(size: int) -> Texts:
    body = f"heuristic h(T: object) {{ start sum(X: base, i: 1 .. {size}) (if (at X) then i else 1) }}\n"
    return _one(body + _task("guide h(b)"))


def _wide_declarations(size: int) -> Texts:
    body = _lines(lambda i: f"predicate (p{i} X: object)", size)
    body += _lines(lambda i: f"derived (d{i} X: object) = (p{i} X)", size)
    return _one(body + _task(""))


def _wide_rules(size: int) -> Texts:
    return _one(_lines(lambda i: f"rule r{i}(X: base) {{ pre (at X) post (open X) cost {i} }}", size) + _task(""))


def _wide_parameters(size: int) -> Texts:
    names = " ".join(f"x{i}" for i in range(size))
    uses = " + ".join(f"x{i}" for i in range(size))
    return _one(f"function f({names}: real) = {uses}\n" + _task(""))


def _wide_quantifier(size: int) -> Texts:
    names = " ".join(f"Y{i}" for i in range(size))
    uses = " and ".join(f"(at Y{i})" for i in range(size))
    return _one(f"derived (d X: object) = (at X) and exists {names}: base {{ {uses} }}\n" + _task(""))


def _wide_imports(size: int) -> Texts:
    texts = {f"f{i}.tamp": f"type t{i} < object\n" for i in range(size)}
    return {MAIN: "".join(f'import "{name}"\n' for name in texts) + WORDS + _task(""), **texts}


def _wide_heuristic(size: int) -> Texts:
    rules = _lines(lambda i: f"rule r{i}(X: base) {{ pre (at X) post (open X), not (at X) }}", size)
    cases = _lines(lambda i: f"r{i}(X): -{i}", size)
    return _one(rules + f"heuristic h(T: object) {{ start 1\n{cases} }}\n" + _task("guide h(b)"))


def _long_number(size: int) -> Texts:
    return _one(f"function f(x: real) = x + 0.{'1' * size}\n" + _task(""))


def _long_name(size: int) -> Texts:
    return _one(f"predicate (p{'x' * size} X: object)\n" + _task(""))


def _long_comment(size: int) -> Texts:
    return _one("## line\n" * size + "predicate (p X: object)\n" + _task(""))


def _long_line(size: int) -> Texts:
    return _one(" ".join(f"predicate (p{i} X: object)" for i in range(size)) + "\n" + _task(""))


def _many_errors(size: int) -> Texts:
    return _one(_lines(lambda i: f"predicate (p{i} X: nothing{i})", size))


def _errors_on_a_line(size: int) -> Texts:
    return _one(" ".join(f"predicate (p{i} X: nothing)" for i in range(size)) + "\n")


def _syntax_errors(size: int) -> Texts:
    return _one(_lines(lambda i: f"predicate (p{i} X; object)", size))


def _unknown_names(size: int) -> Texts:
    return _one(_lines(lambda i: f"derived (d{i} X: object) = (unknown{i} X)", size))


FAMILIES: dict[str, Family] = {
    "doubled functions": Family(_doubled_functions, (10, 20, 40)),
    "doubled arguments": Family(_doubled_arguments, (10, 20, 40)),
    "doubled costs": Family(_doubled_costs, (10, 20, 40)),
    "doubled guards": Family(_doubled_guards, (10, 20, 40)),
    "doubled heuristics": Family(_doubled_heuristics, (10, 20, 40)),
    "doubled conditions": Family(_doubled_conditions, (10, 20, 40)),
    "doubled derived": Family(_doubled_derived, (10, 20, 40)),
    "doubled quantifiers": Family(_doubled_quantifiers, (10, 20, 40)),
    "doubled rows": Family(_doubled_rows, (10, 20, 40)),
    "doubled scenes": Family(_doubled_scenes, (5, 10, 20), lambda size: 2**size),
    "doubled parameters": Family(_doubled_parameters, (10, 20, 40)),
    "chained functions": Family(_chained_functions, (500, 1000, 2000)),
    "chained derived": Family(_chained_derived, (500, 1000, 2000)),
    "chained derived backwards": Family(_chained_derived_backwards, (500, 1000, 2000)),
    "chained types": Family(_chained_types, (1000, 2000, 4000)),
    "chained scenes": Family(_chained_scenes, (500, 1000, 2000)),
    "chained rules": Family(_chained_rules, (500, 1000, 2000)),
    "chained imports": Family(_chained_imports, (100, 500, 2000)),
    "chained bodies": Family(_chained_bodies, (250, 500, 1000)),
    "chained sums": Family(_chained_sums, (50, 1000, 10000)),
    "chained joints": Family(_chained_joints, (250, 500, 1000)),
    "nested groups": Family(_nested_groups, (50, 1000, 10000)),
    "nested minuses": Family(_nested_minuses, (50, 1000, 10000)),
    "nested nots": Family(_nested_nots, (50, 1000, 10000)),
    "nested quantifiers": Family(_nested_quantifiers, (50, 1000, 10000)),
    "nested conditionals": Family(_nested_conditionals, (50, 1000, 10000)),
    "nested calls": Family(_nested_calls, (50, 1000, 10000)),
    "nested loops": Family(_nested_loops, (5, 10, 20), lambda size: 2**size),
    "nested branches": Family(_nested_branches, (50, 1000, 10000)),
    "wide conjunction": Family(_wide_conjunction, (5000, 10000, 20000)),
    "wide disjunction": Family(_wide_disjunction, (5000, 10000, 20000)),
    "wide goal": Family(_wide_goal, (5000, 10000, 20000)),
    "wide precondition": Family(_wide_precondition, (5000, 10000, 20000)),
    "wide effects": Family(_wide_effects, (5000, 10000, 20000)),
    "wide rows": Family(_wide_rows, (2500, 5000, 10000)),
    "wide facts": Family(_wide_facts, (5000, 10000, 20000)),
    "wide bodies": Family(_wide_bodies, (1000, 2000, 4000)),
    "wide loop": Family(_wide_loop, (1000, 2000, 4000)),
    "square loop": Family(_square_loop, (250, 500, 1000), lambda size: size**2),
    "square bodies": Family(_square_bodies, (50, 100, 1000), lambda size: size**2),
    "empty loop": Family(_empty_loop, (250, 500, 1000)),
    "square goal": Family(_square_goal, (50, 100, 1000), lambda size: size**2),
    "wide motion loop": Family(_wide_motion_loop, (2500, 5000, 10000)),
    "wide sum": Family(_wide_sum, (1000, 10000, 100000)),
    "wide declarations": Family(_wide_declarations, (1000, 2000, 4000)),
    "wide rules": Family(_wide_rules, (1000, 2000, 4000)),
    "wide parameters": Family(_wide_parameters, (50, 1000, 2000)),
    "wide quantifier": Family(_wide_quantifier, (500, 1000, 2000)),
    "wide imports": Family(_wide_imports, (250, 500, 1000)),
    "wide heuristic": Family(_wide_heuristic, (500, 1000, 2000)),
    "long number": Family(_long_number, (100000, 300000, 900000)),
    "long name": Family(_long_name, (100000, 300000, 900000)),
    "long comment": Family(_long_comment, (20000, 40000, 80000)),
    "long line": Family(_long_line, (5000, 10000, 20000)),
    "many errors": Family(_many_errors, (2500, 5000, 10000)),
    "errors on a line": Family(_errors_on_a_line, (2500, 5000, 10000)),
    "syntax errors": Family(_syntax_errors, (1000, 2000, 4000)),
    "unknown names": Family(_unknown_names, (1000, 2000, 4000)),
}
