"""Families of programs that grow in width, in length, and by errors."""

from __future__ import annotations

from benchmarks.trust.family_texts import MAIN, WORDS, Texts, lines, one, task_text

# --- width -------------------------------------------------------------------------------------------------------


def wide_conjunction(size: int) -> Texts:
    return one(f"derived (d X: object) = {' and '.join(['(at X)'] * size)}\n" + task_text("", goal="(d b)"))


def wide_disjunction(size: int) -> Texts:
    body = " or ".join(["(at X)", "(open X)"] * (size // 2))
    return one(f"derived (d X: object) = {body}\n" + task_text("", goal="(d b)"))


def wide_goal(size: int) -> Texts:
    return one(task_text("", goal=", ".join(["(at b)"] * size)))


def wide_precondition(size: int) -> Texts:
    rule = f"rule go(X: base) {{ pre {', '.join(['not (at X)'] * size)} post (at X) }}"
    return one(task_text("", rule=rule))


def wide_effects(size: int) -> Texts:
    rule = f"rule go(X: base) {{ pre not (at X) post {', '.join(['(at X)', '(open X)'] * (size // 2))} }}"
    return one(task_text("", rule=rule))


def wide_rows(size: int) -> Texts:
    body = "at switch gap(X, Y) <= 1 m\n" * size
    rule = "rule go(X: base) { pre not (at X) post (at X), [near X X] }"
    return one(f"motion [near X Y: object] {{ {body} }}\n" + task_text("", rule=rule))


def wide_facts(size: int) -> Texts:
    bodies = "object o: box(1 cm, 1 cm, 1 cm) at (0, 3 m, 0)\n"
    return one(task_text(bodies + "fact (open o)\n" * size))


def wide_bodies(size: int) -> Texts:
    line = "object o[{0}]: box(1 cm, 1 cm, 1 cm) at (2 cm * {0}, 3 m, 0)\nfact (open o[{0}])"
    return one(task_text(lines(lambda i: line.format(i), size)))


def wide_loop(size: int) -> Texts:
    line = f"for i in 1 .. {size} {{ object o[i]: box(1 cm, 1 cm, 1 cm) at (2 cm * i, 3 m, 0) fact (open o[i]) }}"
    return one(task_text(line))


def square_loop(size: int) -> Texts:
    loop = f"for i in 1 .. {size} {{ for j in 1 .. {size} {{ fact (open b) }} }}"
    return one(task_text(loop))


def square_bodies(size: int) -> Texts:
    body = "object o[i, j]: box(1 cm, 1 cm, 1 cm) at (2 cm * i, 2 cm * j, 3 m)"
    body = body.replace("o[i, j]", "o[i][j]")
    return one(task_text(f"for i in 1 .. {size} {{ for j in 1 .. {size} {{ {body} }} }}"))


def empty_loop(size: int) -> Texts:
    return one(task_text(f"for i in 1 .. {size} {{ for j in 1 .. {size} {{ if i < 0 {{ fact (open b) }} }} }}"))


def square_goal(size: int) -> Texts:
    return one(task_text("", goal=f"forall i in 1 .. {size} {{ forall j in 1 .. {size} {{ (at b) or i > j }} }}"))


def wide_motion_loop(size: int) -> Texts:
    body = f"for i in 1 .. {size} {{ at switch i * gap(X, Y) <= 1 m }}"
    rule = "rule go(X: base) { pre not (at X) post (at X), [near X X] }"
    return one(f"motion [near X Y: object] {{ {body} }}\n" + task_text("", rule=rule))


def wide_sum(size: int) -> Texts:
    body = f"heuristic h(T: object) {{ start sum(X: base, i: 1 .. {size}) (if (at X) then i else 1) }}\n"
    return one(body + task_text("guide h(b)"))


def wide_declarations(size: int) -> Texts:
    body = lines(lambda i: f"predicate (p{i} X: object)", size)
    body += lines(lambda i: f"derived (d{i} X: object) = (p{i} X)", size)
    return one(body + task_text(""))


def wide_rules(size: int) -> Texts:
    return one(lines(lambda i: f"rule r{i}(X: base) {{ pre (at X) post (open X) cost {i} }}", size) + task_text(""))


def wide_parameters(size: int) -> Texts:
    names = " ".join(f"x{i}" for i in range(size))
    uses = " + ".join(f"x{i}" for i in range(size))
    return one(f"function f({names}: real) = {uses}\n" + task_text(""))


def wide_quantifier(size: int) -> Texts:
    names = " ".join(f"Y{i}" for i in range(size))
    uses = " and ".join(f"(at Y{i})" for i in range(size))
    return one(f"derived (d X: object) = (at X) and exists {names}: base {{ {uses} }}\n" + task_text(""))


def wide_imports(size: int) -> Texts:
    texts = {f"f{i}.tamp": f"type t{i} < object\n" for i in range(size)}
    return {MAIN: "".join(f'import "{name}"\n' for name in texts) + WORDS + task_text(""), **texts}


def wide_heuristic(size: int) -> Texts:
    rules = lines(lambda i: f"rule r{i}(X: base) {{ pre (at X) post (open X), not (at X) }}", size)
    cases = lines(lambda i: f"r{i}(X): -{i}", size)
    return one(rules + f"heuristic h(T: object) {{ start 1\n{cases} }}\n" + task_text("guide h(b)"))


def long_number(size: int) -> Texts:
    return one(f"function f(x: real) = x + 0.{'1' * size}\n" + task_text(""))


def long_name(size: int) -> Texts:
    return one(f"predicate (p{'x' * size} X: object)\n" + task_text(""))


def long_comment(size: int) -> Texts:
    return one("## line\n" * size + "predicate (p X: object)\n" + task_text(""))


def long_line(size: int) -> Texts:
    return one(" ".join(f"predicate (p{i} X: object)" for i in range(size)) + "\n" + task_text(""))


def many_errors(size: int) -> Texts:
    return one(lines(lambda i: f"predicate (p{i} X: nothing{i})", size))


def errors_on_a_line(size: int) -> Texts:
    return one(" ".join(f"predicate (p{i} X: nothing)" for i in range(size)) + "\n")


def syntax_errors(size: int) -> Texts:
    return one(lines(lambda i: f"predicate (p{i} X; object)", size))


def unknown_names(size: int) -> Texts:
    return one(lines(lambda i: f"derived (d{i} X: object) = (unknown{i} X)", size))
