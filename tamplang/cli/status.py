"""The exit statuses of the command line; `docs/cli.md` lists them."""

from __future__ import annotations

from enum import IntEnum


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
    "solved": ExitStatus.DONE,
    "infeasible": ExitStatus.INFEASIBLE,
    "exhausted": ExitStatus.NO_PLAN,
    "budget": ExitStatus.NO_PLAN,
    "memory": ExitStatus.NO_PLAN,
    "refused": ExitStatus.REFUSED,
    "interrupted": ExitStatus.INTERRUPTED,
}
"""The exit status of `solve` for each status of its outcome."""
