"""tamplang: a language and toolchain for task and motion planning of modular, self-reconfiguring robots.

import tamplang
result = tamplang.load("examples/climb.tamp", n=8).solve(time=30.0)
if result.plan is not None:
    result.plan.report("climb.html")
"""

TYPE_CHECKING = False  # as in `typing`, which takes too long to load: the command is to be ready for Ctrl-C at once
if TYPE_CHECKING:
    from .api import Plan, Result, Task, load, read_plan

__all__ = ["Plan", "Result", "Task", "__version__", "load", "read_plan"]
__version__ = "0.1.0"


def __getattr__(name: str) -> object:
    """What `api` offers, loaded at first use."""
    if name in __all__:
        from . import api

        found: object = getattr(api, name)
        return found
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
