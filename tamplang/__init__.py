"""tamplang: a language and toolchain for task and motion planning of modular, self-reconfiguring robots.

import tamplang
result = tamplang.load("examples/climb.tamp", n=8).solve(time=30.0)
if result.plan is not None:
    result.plan.report("climb.html")
"""

from .api import Plan, Result, Task, load, read_plan

__all__ = ["Plan", "Result", "Task", "__version__", "load", "read_plan"]
__version__ = "0.1.0"
