"""tamplang: a language and toolchain for task and motion planning of modular, self-reconfiguring robots.

import tamplang
result = tamplang.load("examples/climb.tamp", n=8).solve(time=30.0)
if result.plan is not None:
    result.plan.report("climb.html")
"""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .api import Plan, Result, Task, load, read_plan

__all__ = ["Plan", "Result", "Task", "__version__", "load", "read_plan"]
__version__ = "0.1.0"


def __getattr__(name: str) -> Any:
    """What `api` offers, loaded at first use, so that the command line is ready for Ctrl-C at once."""
    if name in __all__:
        from . import api

        return getattr(api, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
