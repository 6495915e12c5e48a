"""Families of programs that grow: by nesting, doubling, chaining or width, over the constructs of the language.

A family makes the texts of one program from a size; `main.tamp` is the one that is given to a command. Where a program
has a task, it is named `t`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from benchmarks.trust.family_texts import MAIN, WORDS, Texts, lines, one, task_text
from benchmarks.trust.wide_families import (
    empty_loop,
    errors_on_a_line,
    long_comment,
    long_line,
    long_name,
    long_number,
    many_errors,
    square_bodies,
    square_goal,
    square_loop,
    syntax_errors,
    unknown_names,
    wide_bodies,
    wide_conjunction,
    wide_declarations,
    wide_disjunction,
    wide_effects,
    wide_facts,
    wide_goal,
    wide_heuristic,
    wide_imports,
    wide_loop,
    wide_motion_loop,
    wide_parameters,
    wide_precondition,
    wide_quantifier,
    wide_rows,
    wide_rules,
    wide_sum,
)

__all__ = ["FAMILIES", "MAIN", "Family"]


@dataclass(frozen=True, slots=True)
class Family:
    """`sizes` are those of the upper range, the largest last: what a size counts differs from family to family.

    `parts` says for how many things of the scene a program of a size stands, where that is not the size itself.
    """

    make: Callable[[int], Texts]
    sizes: tuple[int, ...]
    parts: Callable[[int], int] = lambda size: size


# --- doubling: each declaration uses the one before twice --------------------------------------------------------


def _twice(size: int) -> str:
    return "function f0(x: real) = x\n" + lines(lambda i: f"function f{i}(x: real) = f{i - 1}(x) + f{i - 1}(x)", size)


def _doubled_functions(size: int) -> Texts:
    return one(_twice(size))


def _doubled_arguments(size: int) -> Texts:
    body = lines(lambda i: f"function f{i}(x: real) = f{i - 1}(x + x) * f{i - 1}(x)", size)
    return one("function f0(x: real) = x\n" + body)


def _doubled_costs(size: int) -> Texts:
    rule = f"rule go(X Y: base) {{ pre not (at X) post (at X) cost d{size}(X, Y) / 1 m + 1 }}"
    body = "function d0(X Y: object) = distance(X, Y)\n"
    body += lines(lambda i: f"function d{i}(X Y: object) = d{i - 1}(X, Y) + d{i - 1}(Y, X)", size)
    return one(body + task_text("", rule=rule))


def _doubled_guards(size: int) -> Texts:
    rule = f"rule go(X Y: base) {{ pre not (at X) where d{size}(X, Y) >= 0 m post (at X) }}"
    body = "function d0(X Y: object) = distance(X, Y)\n"
    body += lines(lambda i: f"function d{i}(X Y: object) = d{i - 1}(X, Y) / 2 + d{i - 1}(Y, X)", size)
    return one(body + task_text("", rule=rule))


def _doubled_heuristics(size: int) -> Texts:
    body = "function d0(X Y: object) = distance(X, Y)\n"
    body += lines(lambda i: f"function d{i}(X Y: object) = d{i - 1}(X, Y) + d{i - 1}(Y, X)", size)
    body += f"heuristic h(T: object) {{ start 1  go(X): d{size}(X, T) }}\n"
    return one(body + task_text("guide h(b)"))


def _doubled_conditions(size: int) -> Texts:
    body = "function d0(X: object) = if (at X) then 1 else 2\n"
    body += lines(lambda i: f"function d{i}(X: object) = if d{i - 1}(X) > 1 then d{i - 1}(X) else 3", size)
    body += f"heuristic h(T: object) {{ start 1  go(X): d{size}(X) }}\n"
    return one(body + task_text("guide h(b)"))


def _doubled_derived(size: int) -> Texts:
    body = "derived (d0 X: object) = (at X)\n"
    body += lines(lambda i: f"derived (d{i} X: object) = (d{i - 1} X) and not (d{i - 1} X) or (d{i - 1} X)", size)
    return one(body + task_text("", goal=f"(d{size} b)"))


def _doubled_quantifiers(size: int) -> Texts:
    body = "derived (d0 X: object) = (at X)\n"
    line = "derived (d{0} X: object) = exists Y: base {{ (d{1} Y) and not (d{1} X) }} or (d{1} X)"
    body += lines(lambda i: line.format(i, i - 1), size)
    return one(body + task_text("", goal=f"(d{size} b)"))


def _doubled_rows(size: int) -> Texts:
    body = "function d0(X Y: object) = gap(X, Y)\n"
    body += lines(lambda i: f"function d{i}(X Y: object) = gap(X, Y) + d{i - 1}(X, Y) + d{i - 1}(Y, X)", size)
    body += f"motion [near X Y: object] {{ at switch d{size}(X, Y) <= 1 m }}\n"
    rule = "rule go(X: base) { pre not (at X) post (at X), [near X X] }"
    return one(body + task_text("", rule=rule))


def _doubled_scenes(size: int) -> Texts:
    body = "scene s0(x: length) { }\n"
    body += lines(lambda i: f"scene s{i}(x: length) {{ scene s{i - 1}(x) scene s{i - 1}(x + 1 m) }}", size)
    return one(body + task_text(f"scene s{size}(1 m)"))


def _doubled_parameters(size: int) -> Texts:
    body = _twice(size)
    return one(body + task_text(f"object o: box(1 cm, 1 cm, 1 cm) at (f{size}(0.0001), 3 m, 0)"))


# --- chaining: each uses the one before, or follows from it ------------------------------------------------------


def _chained_functions(size: int) -> Texts:
    body = "function f0(x: real) = x\n" + lines(lambda i: f"function f{i}(x: real) = f{i - 1}(x) + 1", size)
    return one(body + task_text(f"object o: box(1 cm, 1 cm, 1 cm) at (f{size}(1) * 1 mm, 3 m, 0)"))


def _chained_derived(size: int) -> Texts:
    body = "derived (d0 X: object) = (at X)\n"
    body += lines(lambda i: f"derived (d{i} X: object) = (d{i - 1} X) or (open X)", size)
    return one(body + task_text("", goal=f"(d{size} b)"))


def _chained_derived_backwards(size: int) -> Texts:
    body = "derived (d0 X: object) = (at X)\n"
    body += "\n".join(f"derived (d{i} X: object) = (d{i - 1} X) or (open X)" for i in range(size, 0, -1)) + "\n"
    return one(body + task_text("", goal=f"(d{size} b)"))


def _chained_types(size: int) -> Texts:
    body = "type t0 < base\n" + lines(lambda i: f"type t{i} < t{i - 1}", size)
    items = f"t{size} o: box(1 cm, 1 cm, 1 cm) at (0, 3 m, 0)"
    return one(body + task_text(items))


def _chained_scenes(size: int) -> Texts:
    body = "scene s0() { object o: box(1 cm, 1 cm, 1 cm) at (0, 3 m, 0) }\n"
    body += lines(lambda i: f"scene s{i}() {{ scene s{i - 1}() }}", size)
    return one(body + task_text(f"scene s{size}()"))


def _chained_rules(size: int) -> Texts:
    body = lines(lambda i: f"predicate (p{i} X: object)", size, 0)
    body += lines(lambda i: f"rule r{i}(X: base) {{ pre (p{i - 1} X) post (p{i} X), not (p{i - 1} X) }}", size)
    return one(body + task_text("fact (p0 b)", goal=f"(p{size} b)"))


def _chained_imports(size: int) -> Texts:
    texts = {f"f{i}.tamp": f'import "f{i + 1}.tamp"\ntype t{i} < object\n' for i in range(1, size)}
    texts[f"f{size}.tamp"] = f"type t{size} < object\n"
    return {MAIN: 'import "f1.tamp"\n' + WORDS + task_text(""), **texts}


def _chained_bodies(size: int) -> Texts:
    body = "object o[0]: box(1 cm, 1 cm, 1 cm) on g at (0, 0)\n"
    body += lines(lambda i: f"object o[{i}]: box(1 cm, 1 cm, 1 cm) on o[{i - 1}]", size)
    return one(task_text(body))


def _chained_sums(size: int) -> Texts:
    return one(f"function f(x: real) = {' + '.join(['x'] * size)}\n" + task_text(""))


def _chained_joints(size: int) -> Texts:
    body = lines(lambda i: f"joint j{i}: revolute(y) in -1 rad .. 1 rad\nlink 1 mm: capsule(1 mm)", size)
    text = f"module long() {{ effector A: foot sphere(1 cm)\n{body}effector B: foot sphere(1 cm) }}\n"
    return one(text + task_text("long l: at (0, 3 m, 1 m)"))


# --- nesting -----------------------------------------------------------------------------------------------------


def _nested_groups(size: int) -> Texts:
    return one(f"function f(x: real) = {'(' * size}x{')' * size}\n" + task_text(""))


def _nested_minuses(size: int) -> Texts:
    return one(f"function f(x: real) = {'-' * size}x\n" + task_text(""))


def _nested_nots(size: int) -> Texts:
    return one(f"derived (d X: object) = {'not ' * size}(at X)\n" + task_text(""))


def _nested_quantifiers(size: int) -> Texts:
    heads = "".join(f"exists Y{i}: base {{ " for i in range(size))
    return one(f"derived (d X: object) = {heads}(at X){' }' * size}\n" + task_text(""))


def _nested_conditionals(size: int) -> Texts:
    heads = "".join(f"if x > {i} then {i} else " for i in range(size))
    return one(f"function f(x: real) = {heads}0\n" + task_text(""))


def _nested_calls(size: int) -> Texts:
    return one(f"function f(x: real) = {'abs(' * size}x{')' * size}\n" + task_text(""))


def _nested_loops(size: int) -> Texts:
    heads = "".join(f"for i{k} in 1 .. 2 {{ " for k in range(size))
    return one(task_text(f"{heads}fact (open b){' }' * size}"))


def _nested_branches(size: int) -> Texts:
    body = "branch { link 1 mm " * size + "}" * size
    return one(f"module long() {{ effector A: foot sphere(1 cm)\n{body} }}\n" + task_text(""))


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
    "wide conjunction": Family(wide_conjunction, (5000, 10000, 20000)),
    "wide disjunction": Family(wide_disjunction, (5000, 10000, 20000)),
    "wide goal": Family(wide_goal, (5000, 10000, 20000)),
    "wide precondition": Family(wide_precondition, (5000, 10000, 20000)),
    "wide effects": Family(wide_effects, (5000, 10000, 20000)),
    "wide rows": Family(wide_rows, (2500, 5000, 10000)),
    "wide facts": Family(wide_facts, (5000, 10000, 20000)),
    "wide bodies": Family(wide_bodies, (1000, 2000, 4000)),
    "wide loop": Family(wide_loop, (1000, 2000, 4000)),
    "square loop": Family(square_loop, (250, 500, 1000), lambda size: size**2),
    "square bodies": Family(square_bodies, (50, 100, 1000), lambda size: size**2),
    "empty loop": Family(empty_loop, (250, 500, 1000)),
    "square goal": Family(square_goal, (50, 100, 1000), lambda size: size**2),
    "wide motion loop": Family(wide_motion_loop, (2500, 5000, 10000)),
    "wide sum": Family(wide_sum, (1000, 10000, 100000)),
    "wide declarations": Family(wide_declarations, (1000, 2000, 4000)),
    "wide rules": Family(wide_rules, (1000, 2000, 4000)),
    "wide parameters": Family(wide_parameters, (50, 1000, 2000)),
    "wide quantifier": Family(wide_quantifier, (500, 1000, 2000)),
    "wide imports": Family(wide_imports, (250, 500, 1000)),
    "wide heuristic": Family(wide_heuristic, (500, 1000, 2000)),
    "long number": Family(long_number, (100000, 300000, 900000)),
    "long name": Family(long_name, (100000, 300000, 900000)),
    "long comment": Family(long_comment, (20000, 40000, 80000)),
    "long line": Family(long_line, (5000, 10000, 20000)),
    "many errors": Family(many_errors, (2500, 5000, 10000)),
    "errors on a line": Family(errors_on_a_line, (2500, 5000, 10000)),
    "syntax errors": Family(syntax_errors, (1000, 2000, 4000)),
    "unknown names": Family(unknown_names, (1000, 2000, 4000)),
}
