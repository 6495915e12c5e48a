"""The command `compile`: look into any stage."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ..langs.counting import counted
from .libraries import needing_libraries
from .limits import limit_options, limited
from .parameters import WholeNumber, parameters_option
from .sources import reading_sources

if TYPE_CHECKING:
    from ..compiler.ir import MotionPredicate, Problem, Row
    from ..compiler.symbolic.successors import Successors

STATES_TO_VISIT, BLOCKS_TO_TRY = 1000, 50_000
"""How many states `ground` and `successors` visit, and how many groups of actions they try in all of these: the back
end grounds and generates as the search goes. States of the examples have some 10 groups each; the second
bound keeps the walk from growing with the square of the number of rules."""


def _ast(file: Path) -> str:
    from ..compiler.printing import format_ast
    from ..langs.diagnostics import SourceError
    from ..langs.parser import parse
    from ..langs.reader import read_source

    tree, diagnostics = parse(read_source(file))
    if diagnostics:
        raise SourceError(diagnostics)
    return format_ast(tree)


def _ir(problem: Problem) -> str:
    from ..compiler.printing import format_ir

    return format_ir(problem)


def _ground(problem: Problem) -> str:
    """Objects, facts at the start, and the ground actions met in the first states of a breadth-first walk."""
    successors, states = _walked(problem)
    actions = sorted(str(successors.action(number)) for number in range(successors.action_count))
    objects = [f"  {name}: {type_name}" for name, type_name in problem.objects.items()]
    facts = [f"  ({' '.join(fact)})" for fact in sorted(problem.init)]
    facts += [f"  [{' '.join(fact)}]" for fact in sorted(problem.init_motion)]
    heading = f"{counted(len(actions), 'action')} in the first {counted(states, 'state')}"
    return "\n".join(
        ["objects", *objects, "facts at the start", *facts, heading, *(f"  {action}" for action in actions)]
    )


def _successors(problem: Problem) -> str:
    return _walked(problem)[0].source()


def _walked(problem: Problem) -> tuple[Successors, int]:
    """The successor functions after a breadth-first walk, and how many states it met."""
    from ..compiler.symbolic.successors import Successors

    successors = Successors(problem)
    seen = {successors.initial}
    queue = deque(seen)
    tried = 0
    while queue and len(seen) < STATES_TO_VISIT and tried < BLOCKS_TO_TRY:
        visited = queue.popleft()
        tried += len(successors.blocks(visited))
        for state, _ in successors.expand(visited):
            if state not in seen:
                seen.add(state)
                queue.append(state)
    return successors, len(seen)


def _constraints(problem: Problem) -> str:
    """Every motion predicate with the text of each row, its size, its units, what it speaks of and its place."""
    texts = {source.path: source.text for source in problem.sources}
    lines = []
    for predicate in problem.motions.values():
        names = " ".join(v.name for v in predicate.variables)
        lines.append(f"[{predicate.name} {names}]{' symmetric' if predicate.symmetric else ''}")
        for row in predicate.rows:
            text = texts[row.span.file][row.span.start : row.span.end] if row.span is not None else row.when
            lines.append(f"  {text}  # {_described(row, predicate)}")
    return "\n".join(lines)


def _described(row: Row, predicate: MotionPredicate) -> str:
    from ..compiler.motion.constraints import arguments, units

    size = "1 row" if row.rows == 1 else f"{row.rows} rows"
    of = ", ".join(arguments(row, predicate.variables))
    return f"{size} in {'/'.join(dict.fromkeys(units(row)))} of {of}; {row.span}"


def _costs(problem: Problem) -> str:
    """What each action costs, and how the task's heuristic changes the cost-to-go with it."""
    from ..compiler.printing_terms import format_term

    lines = [f"cost of {rule.name}: {format_term(rule.cost)}" for rule in problem.rules.values()]
    heuristic = problem.heuristic
    if heuristic is None:
        return "\n".join([*lines, "no heuristic"])
    start = "0" if heuristic.start is None else format_term(heuristic.start)
    lines += [f"heuristic {heuristic.name}", f"  start: {start}"]
    return "\n".join([*lines, *(f"  {name}: {format_term(case.value)}" for name, case in heuristic.cases.items())])


def _pddl(problem: Problem) -> str:
    from ..compiler.symbolic.pddl import to_pddl

    domain, task = to_pddl(problem)
    return f"{domain}\n{task}"


STAGES: dict[str, Callable[[Problem], str]] = {
    "ir": _ir,
    "ground": _ground,
    "successors": _successors,
    "constraints": _constraints,
    "costs": _costs,
    "pddl": _pddl,
}


@click.command("compile")
@click.argument("file", metavar="FILE", type=click.Path(path_type=Path))
@click.argument("task", required=False)
@click.option("--emit", type=click.Choice(["ast", *STAGES]), required=True, help="The stage to print.")
@parameters_option
@limit_options
@click.option("--seed", type=WholeNumber(0), default=0, show_default=True, help="For the scene.")
def compile_command(
    file: Path, task: str | None, emit: str, parameters: dict[str, str], seed: int, seconds: float, memory: int | None
) -> None:
    """Print one stage of the compiler for the TASK of FILE."""
    with limited(seconds, memory, f"compiling {file}"), reading_sources(), needing_libraries():
        if emit == "ast":
            click.echo(_ast(file))
            return
        from ..compiler.pipeline import compile_problem

        problem, _ = compile_problem(file, task, parameters, seed)
        click.echo(STAGES[emit](problem).rstrip("\n"))
