"""tamplang: a language and toolchain for task and motion planning of modular, self-reconfiguring robots.

import tamplang
result = tamplang.load("examples/climb.tamp", n=8).solve(time=30.0)
if result.plan is not None:
    result.plan.report("climb.html")
"""

TYPE_CHECKING = False  # as in `typing`, which takes too long to load: the command is to be ready for Ctrl-C at once
if TYPE_CHECKING:
    from .api import Plan, Result, RunResult, Task, load, loads, read_plan
    from .langs.diagnostics import Error, SourceError, UsageError
    from .runtime.budget import OutOfTime
    from .runtime.native import MissingLibrary
    from .runtime.parallel import ClusterUnavailable
    from .runtime.plan_files import PlanFileError
    from .runtime.simulation.actuators import Noise
    from .texts import Text, degrees, fill, metres, radians

__all__ = [
    "ClusterUnavailable", "Error", "MissingLibrary", "Noise", "OutOfTime", "Plan", "PlanFileError", "Result",
    "RunResult", "SourceError", "Task", "Text", "UsageError", "__version__", "degrees", "fill", "load", "loads",
    "metres", "radians", "read_plan",
]  # fmt: skip
_HOMES = {
    "ClusterUnavailable": ".runtime.parallel",
    "Error": ".langs.diagnostics",
    "MissingLibrary": ".runtime.native",
    "Noise": ".runtime.simulation.actuators",
    "OutOfTime": ".runtime.budget",
    "PlanFileError": ".runtime.plan_files",
    "SourceError": ".langs.diagnostics",
    "Text": ".texts",
    "UsageError": ".langs.diagnostics",
    "degrees": ".texts",
    "fill": ".texts",
    "metres": ".texts",
    "radians": ".texts",
}
"""Where names are that `api` has not."""
__version__ = "0.1.0"


def __getattr__(name: str) -> object:
    """What `api` and the errors offer, loaded at first use."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    found: object = getattr(import_module(_HOMES.get(name, ".api"), __name__), name)
    return found


def __dir__() -> list[str]:
    """What is offered, also what is not loaded yet, and the module's own attributes."""
    return sorted({*(name for name in globals() if name.startswith("__")), *__all__})
