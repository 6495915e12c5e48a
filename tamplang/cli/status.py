"""The exit statuses of the command line; `docs/cli.md` lists them."""

from __future__ import annotations

from enum import IntEnum

from ..runtime.budget import Status


class ExitStatus(IntEnum):
    """What the process tells its caller."""

    DONE = 0
    SOURCE_ERRORS = 1
    USAGE = 2
    INFEASIBLE = 3
    NO_PLAN = 4
    REFUSED = 5
    UNFINISHED = 6
    INTERNAL_ERROR = 70
    INTERRUPTED = 130


OF_OUTCOME = {
    Status.SOLVED: ExitStatus.DONE,
    Status.INFEASIBLE: ExitStatus.INFEASIBLE,
    Status.EXHAUSTED: ExitStatus.NO_PLAN,
    Status.BUDGET: ExitStatus.NO_PLAN,
    Status.MEMORY: ExitStatus.NO_PLAN,
    Status.REFUSED: ExitStatus.REFUSED,
    Status.INTERRUPTED: ExitStatus.INTERRUPTED,
}
"""The exit status of `solve` for each status of its outcome."""
