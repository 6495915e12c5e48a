"""The experiments of the thesis (tables 3 to 6) and beyond: our figures beside the thesis' own.

    tamplang bench thesis [--seeds 5] [--rows TEXT] [--time S] [--out FILE.json] [--markdown FILE.md]

One process `tamplang solve` per row and seed, one after the other, on one core, with path bound, collisions and
verification. With --out, runs are kept in FILE.json as they end and not run again. --rows takes the rows whose name
contains TEXT, such as "climb n=8" or "table 5".
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import _runs as bench

ASPIRED = 50
"""By how much we want to beat a figure of the thesis above `LONG` seconds."""
Figures = tuple[float, int, int, int]
"""Of the thesis: seconds, tree nodes, expanded nodes, length of the solution."""


@dataclass(frozen=True, slots=True)
class Row:
    """One line of a table: our task with its parameters, and what the thesis has there; None for a dash."""

    table: str
    file: str
    parameters: tuple[tuple[str, int], ...]
    thesis: Figures | None

    @property
    def task(self) -> str:
        return " ".join((self.file, *(f"{name}={value}" for name, value in self.parameters)))

    @property
    def name(self) -> str:
        return f"{self.table}: {self.task}"

    @property
    def goal(self) -> float | None:
        """Seconds of the whole process; None where only a short time without process start counts."""
        return bench.goal_of(None if self.thesis is None else self.thesis[0])


def _rows(table: str, file: str, name: str, figures: dict[int, Figures | None], **fixed: int) -> list[Row]:
    return [Row(table, file, ((name, n), *fixed.items()), thesis) for n, thesis in figures.items()]


TWO_CRAWLERS: dict[int, Figures | None] = {
    1: (0.33, 21, 3, 2), 2: (3.83, 111, 17, 7), 4: (5.38, 190, 22, 8), 8: (7.25, 309, 23, 9),
    16: (35.76, 685, 29, 12), 32: (309.43, 2488, 53, 20), 64: (470.58, 4088, 53, 27),
}  # fmt: skip
WITHOUT_HEURISTICS: dict[int, Figures | None] = {
    1: (2.31, 65, 8, 2), 2: (7.98, 211, 22, 2), 4: (350.16, 2746, 591, 5), 8: None, 16: None, 32: None, 64: None,
}  # fmt: skip
ONE_CRAWLER: dict[int, Figures | None] = {
    1: (0.09, 10, 2, 2), 2: (0.85, 57, 13, 5), 4: (0.99, 85, 13, 7), 8: (11.39, 181, 17, 10),
    16: (26.29, 505, 27, 16), 32: (423.16, 4421, 129, 43), 64: None,
}  # fmt: skip
RENDEZVOUS: dict[int, Figures | None] = {
    1: (23.13, 883, 117, 13), 2: (31.18, 1293, 157, 13), 4: (19.35, 671, 67, 11), 8: (28.35, 1157, 77, 12),
}  # fmt: skip
MOBILE: dict[int, Figures | None] = {
    1: (0.97, 7, 2, 3), 2: (2.67, 12, 4, 4), 4: (6.46, 25, 8, 9), 8: (45.61, 68, 19, 17),
}  # fmt: skip
ROWS = [
    *_rows("table 3, with heuristics, and table 4, two crawlers", "climb", "n", TWO_CRAWLERS, crawlers=2),
    *_rows("table 3, without heuristics", "climb", "n", WITHOUT_HEURISTICS, crawlers=2),
    *_rows("table 4, one crawler", "climb", "n", ONE_CRAWLER, crawlers=1),
    *_rows("table 5", "rendezvous", "n", RENDEZVOUS),
    *_rows("table 6", "mobile_manipulator", "objects", MOBILE),
    *_rows("beyond", "climb", "n", {128: None, 256: None}, crawlers=2),
    *_rows("beyond", "mobile_manipulator", "objects", {32: None, 64: None}),
    *_rows("beyond", "chain_climb", "modules", {8: None}),
]
BEYOND = "beyond"


def run_of(row: Row, limit: float, seed: int, folder: Path) -> bench.Run:
    return bench.solve(row.file, row.parameters, seed, limit, folder / "plan.json", "--bound", "path")


def line(row: Row, runs: Sequence[bench.Run]) -> str:
    solved = bench.good(runs)
    wall, inside = bench.middle(solved, "wall"), bench.median([bench.seconds(run, "total") for run in solved])
    goal, met = "–", "–"
    if row.table != BEYOND:
        goal = f"{row.goal:.1f}" if row.goal is not None else f"{bench.SHORT_GOAL:g} + start"
        reached = wall <= row.goal if row.goal is not None else inside <= bench.SHORT_GOAL
        met = "yes" if solved and reached else "no"
        if row.thesis is None:
            goal, met = "solved", "yes" if len(solved) == len(runs) else "no"
    ratio = f"{row.thesis[0] / wall:.1f}" if row.thesis is not None and solved else "–"
    theirs = [f"{row.thesis[0]:g}", *map(str, row.thesis[1:])] if row.thesis is not None else ["–"] * 4
    counts = (bench.middle(solved, name) for name in ("tree_nodes", "expanded_nodes", "length"))
    times = (wall, bench.worst(solved), inside, bench.middle(solved, "cpu"))
    ours = [bench.number(x) for x in times] + [bench.number(x, 0) for x in counts] + [f"{len(solved)}/{len(runs)}"]
    return f"| {' | '.join((row.task, *theirs, *ours, ratio, goal, met))} |"


HEADINGS = (
    "task", "thesis s", "tree", "expanded", "length", "ours s", "worst s", "without start s", "CPU s", "tree",
    "expanded", "length", "verified", "thesis / ours", "goal s", "met",
)  # fmt: skip


def markdown(rows: Sequence[Row], runs: bench.Runs, seeds: int) -> str:
    """One table per table of the thesis."""
    kept = {task: [run for seed, run in found.items() if int(seed) < seeds] for task, found in runs.items()}
    peak = max((int(str(run["peak_mb"])) for found in kept.values() for run in found), default=0)
    text = [
        "# The experiments of the thesis, and beyond",
        "",
        "Made by `tamplang bench thesis --markdown docs/benchmarks-thesis.md`: one process per row and seed, one after "
        "the other, on one core, with path bound, collisions and verification.",
        "",
        f"{bench.today()}, {bench.machine()}, seeds 0 to {seeds - 1}; at most {peak} MB. Times are medians over seeds; "
        f"the goal is a {bench.FACTOR}th of the thesis' time (a {ASPIRED}th is aspired to) where that is above "
        f"{bench.LONG:g} s, else {bench.SHORT_GOAL:g} s without process start. Ours are the "
        "same runs with and without heuristics: the default search asks for none."
    ]
    title = ""
    for row in rows:
        if row.table != title:
            title = row.table
            text += bench.table(title, HEADINGS)
        if row.task in kept:
            text.append(line(row, kept[row.task]))
    return "\n".join(text) + "\n"


def main() -> None:
    given = bench.options("thesis", __doc__ or "", 120.0)
    rows = [row for row, taken in zip(ROWS, bench.chosen([row.name for row in ROWS], given.rows), strict=True) if taken]
    runs = bench.measure({row.task: partial(run_of, row, given.time) for row in rows}, given.seeds, given.out)
    bench.tell(markdown(rows, runs, given.seeds), given.markdown)


if __name__ == "__main__":
    main()
