"""How a solve ended that found no plan, for the page: in words, and in a colour."""

from __future__ import annotations

from collections.abc import Sequence

from ...compiler.ir import Problem
from ...langs.diagnostics import Diagnostic
from ...langs.frozen import dataclass
from ...langs.render import render
from ...langs.source import Source
from ..budget import Status

HEADLINES = {
    Status.INFEASIBLE: "no plan: proved",
    Status.EXHAUSTED: "no plan found",
    Status.BUDGET: "unfinished",
    Status.MEMORY: "unfinished",
    Status.INTERRUPTED: "unfinished",
    Status.REFUSED: Status.REFUSED,
}
WHY = {
    Status.INFEASIBLE: "It is proved that no sequence of actions reaches the goal.",
    Status.EXHAUSTED: "Every candidate was refused, which is no proof that there is none.",
    Status.BUDGET: "The time or the nodes were spent; with more of them the search would go on.",
    Status.MEMORY: "The memory was spent; with more of it the search would go on.",
    Status.INTERRUPTED: "The run was ended by its user.",
    Status.REFUSED: "The verifier refuses the plan that was found.",
}


@dataclass(frozen=True, slots=True)
class Ending:
    """`status` is that of the solve; `told` holds what refused the task, as code and text with the lines that it points
    to."""

    status: Status
    told: tuple[tuple[str, str], ...]

    @property
    def headline(self) -> str:
        return HEADLINES[self.status]

    @property
    def why(self) -> str:
        return WHY[self.status]

    @property
    def colour(self) -> str:
        """The class of the verdict: red for what is proved or refused, amber for what is open."""
        return "refused" if self.status in (Status.INFEASIBLE, Status.REFUSED) else "unfinished"


def ending_of(problem: Problem, status: Status, explanation: Sequence[Diagnostic]) -> Ending:
    """The ending of a solve of `problem`."""
    sources: dict[str, Source] = {s.path: s for s in problem.sources}
    return Ending(status, tuple((d.code, render([d], sources)) for d in explanation))
