"""A second checker of plan files, written from docs/plan-format.md and docs/language.md alone.

It shares no code with planner and verifier. Of tamplang it uses only the compiler, which turns the sources of a plan
into rules, scene and goal. Rules are interpreted here, splines are SciPy's, kinematics NumPy's, distances coal's
between shapes whose motion is bounded from one instant to the next.

Limits are those of the page. Where the page leaves room, the checker is the milder one: what it refuses is wrong.
"""

from .form import read
from .judge import Finding, judge

__all__ = ["Finding", "judge", "read"]
