"""Two plans on one page: what differs in a table, and their reports side by side, with replays in step."""

from __future__ import annotations

import re
from difflib import SequenceMatcher
from pathlib import Path

from markupsafe import Markup

from ...langs.frozen import dataclass
from ...langs.writer import write_atomically
from ..plan import Plan
from .clearance import build_clearance
from .render import FOLDER, environment, render_report, script_hash, script_text
from .view import figure, machine, measure_name

NOISE = 1e-3
"""What part of its limit a figure has to be, to be told."""
_HASH = re.compile(r"'sha256-[A-Za-z0-9+/=]+'")


@dataclass(frozen=True, slots=True)
class Difference:
    """A line of the comparison: a figure of both plans, or an action of both or of one of them."""

    name: str
    first: str
    second: str

    @property
    def same(self) -> bool:
        return self.first == self.second


def write_comparison(first: Plan, second: Plan, names: tuple[str, str], path: str | Path, checked: bool = True) -> None:
    """Write the page of two plans, atomically; `names` say which they are. Raises OSError."""
    pages = render_report(first, checked), render_report(second, checked)
    script = script_text((FOLDER / "compare.js").read_text(encoding="utf-8"))
    hashes = dict.fromkeys([str(script_hash(script)), *(h for page in pages for h in _HASH.findall(page))])
    text = environment().get_template("compare.html.j2").render(
        names=names, pages=pages, figures=figures(first, second), actions=actions(first, second), script=script,
        total=max(_seconds(first), _seconds(second)), hashes=[Markup(h) for h in hashes],
        style=Markup((FOLDER / "report.css").read_text(encoding="utf-8")),
    )  # fmt: skip
    write_atomically(path, text.encode())


def figures(first: Plan, second: Plan) -> list[Difference]:
    """Cost, times and what the verifier measured, where both plans have it."""
    rows = [
        Difference("Task", first.task.name, second.task.name),
        Difference("Parameters", _parameters(first), _parameters(second)),
        Difference("Seed", str(first.task.seed), str(second.task.seed)),
        Difference("Verdict", _verdict(first), _verdict(second)),
        Difference("Actions", str(len(first.phases)), str(len(second.phases))),
        Difference("Cost", f"{first.statistics.cost:g}", f"{second.statistics.cost:g}"),
        Difference("Motion", f"{_seconds(first):.2f} s", f"{_seconds(second):.2f} s"),
        Difference("Least clearance", _clearance(first), _clearance(second)),
        Difference("Search tree", f"{first.statistics.tree_nodes} nodes", f"{second.statistics.tree_nodes} nodes"),
    ]
    computed = Difference("Computed on", machine(first) or "–", machine(second) or "–")
    rows += [computed] if machine(first) or machine(second) else []
    left, right = (_measured(plan) for plan in (first, second))
    return rows + [Difference(measure_name(kind), left[kind], right[kind]) for kind in left if kind in right]


def actions(first: Plan, second: Plan) -> list[Difference]:
    """The actions of both, in their order, those that are the same beside each other."""
    left, right = ([phase.action for phase in plan.phases] for plan in (first, second))
    rows: list[Difference] = []
    for _, i, j, k, m in SequenceMatcher(None, left, right, autojunk=False).get_opcodes():
        for n in range(max(j - i, m - k)):
            one, other = "".join(left[i + n : j][:1]), "".join(right[k + n : m][:1])
            rows.append(Difference(str(len(rows) + 1), one, other))
    return rows


def _measured(plan: Plan) -> dict[str, str]:
    """The worst figure of each kind; what is far below its limit is rounding, and counts as 0."""
    measures = [] if plan.verdict is None else plan.verdict.measures
    return {m.kind: figure(m.amount if abs(m.amount) > NOISE * m.limit else 0.0, m.unit) for m in measures}


def _parameters(plan: Plan) -> str:
    return ", ".join(f"{name} = {value}" for name, value in plan.task.parameters.items()) or "–"


def _clearance(plan: Plan) -> str:
    """The least distance of a robot to what it does not touch, and which two things it is between."""
    least = min(build_clearance(plan), key=lambda c: c.least, default=None)
    return "–" if least is None else f"{1000.0 * least.least:.1f} mm, {least.first} and {least.second}"


def _seconds(plan: Plan) -> float:
    return plan.times[-1] if plan.times else 0.0


def _verdict(plan: Plan) -> str:
    if plan.verdict is None:
        return "not checked"
    if not plan.verdict.verified:
        return "refused"
    return "verified" if plan.verdict.goal_reached else "goal not reached"
