"""What a user may set of the planner, once: the `options` block of a task, the command line, the Python interface and
`docs/cli.md` are made of this table, or held to it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from ..langs.diagnostics import UsageError, did_you_mean
from ..langs.frozen import dataclass
from .objectives import Objective


@dataclass(frozen=True, slots=True)
class Option:
    """`kind` is "word" (one of `choices`), "whole" (a number from 1, to `most` if that is given), "time" (seconds),
    "length" (metres), "objective" (a weighted sum of measures), "number" (from 1) or "amount" (from 0). Without
    `default` nothing is limited, or the task's scene decides. `places` are where it may be given: "task" (the `options`
    block), "solve" and "sweep" (the commands), "python" (`Task.solve`)."""

    name: str
    kind: str
    help: str
    places: frozenset[str]
    default: Any = None
    choices: tuple[str, ...] = ()
    most: int | None = None

    @property
    def hint(self) -> str:
        """What it is, as the end of a message says it."""
        return self.help[0].lower() + self.help[1:].rstrip(".")


EVERYWHERE = frozenset(("task", "solve", "sweep", "python"))

OPTIONS: Mapping[str, Option] = {
    option.name: option
    for option in (
        Option("bound", "word", "The finest motion bound to try.", EVERYWHERE, "path", ("seq", "seq-path", "path")),
        Option("search", "word", "How to look for skeletons.", EVERYWHERE, "astar",
               ("astar", "wastar", "bfs", "guide")),
        Option("time", "time", "Seconds, reading and compiling included; inf for no limit.", EVERYWHERE, 60.0),
        Option("nodes", "whole", "How large the search tree may grow.", EVERYWHERE),
        Option("solver", "word", "For the motion programs.", EVERYWHERE, "algn", ("algn", "ipopt")),
        Option("slices", "whole", "Time steps of a phase.", frozenset(("task", "python"))),
        Option("physics", "word", "Whether robots must bear themselves: at rest, or also in motion.",
               frozenset(("task",)), "none", ("none", "statics", "dynamics")),
        Option("safety", "number", "How many times its load everything must bear.", frozenset(("task",)), 1.5),
        Option("margin", "length", "Distance that things wish to keep, metres.", frozenset(("task",))),
        Option("minimise", "objective", "What plans are to be best at.", frozenset(("task", "solve", "python")),
               "actions"),
        Option("gap", "amount", "Go on until no plan can be better by more than this, as far as is known.",
               frozenset(("task", "solve", "python"))),
        Option("solutions", "whole", "How many plans to find.", frozenset(("solve", "python")), 1, most=1000),
    )
}  # fmt: skip


def given_at(place: str) -> dict[str, Option]:
    """The options that may be given there."""
    return {name: option for name, option in OPTIONS.items() if place in option.places}


def check_given(place: str, given: Mapping[str, object], more: tuple[str, ...] = ()) -> None:
    """Raises UsageError for a name that is neither an option of that place nor one of `more`, and for a value that an
    option does not take; None stands for one that is not given."""
    known = given_at(place)
    for name, value in given.items():
        if name in more or (name in known and value is None):
            continue
        if name not in known:
            raise UsageError(f"there is no option `{name}`", help=did_you_mean(name, [*known, *more]))
        fault = _fault(known[name], value)
        if fault is not None:
            near = did_you_mean(value, known[name].choices) if isinstance(value, str) else None
            raise UsageError(f"option `{name}` is {fault}, not {value!r}", help=near)


def _fault(option: Option, value: object) -> str | None:
    """What a value should be and is not."""
    if option.kind == "word":
        return None if value in option.choices else f"one of {', '.join(option.choices)}"
    if option.kind == "whole":
        most = math.inf if option.most is None else option.most
        fits = isinstance(value, int) and not isinstance(value, bool) and 1 <= value <= most
        return None if fits else "a whole number from 1" + (f" to {option.most}" if option.most else "")
    if option.kind == "number":
        fits = isinstance(value, int | float) and not isinstance(value, bool) and 1 <= value < math.inf
        return None if fits else "a number from 1"
    if option.kind == "amount":
        fits = isinstance(value, int | float) and not isinstance(value, bool) and 0 <= value < math.inf
        return None if fits else "a number from 0"
    if option.kind == "objective":
        if isinstance(value, str):
            from .objective_terms import spelled

            spelled(value)
        return None if isinstance(value, str | Objective) else "an objective such as makespan + 0.1 * travel"
    number = value if isinstance(value, int | float) and not isinstance(value, bool) else math.nan
    if option.kind == "time":
        return None if number > 0 else "a number of seconds above 0"
    return None if number >= 0 else "a length in metres from 0"
