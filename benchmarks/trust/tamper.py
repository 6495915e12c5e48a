"""Tampered plans: what `tamplang verify` accepts though it is wrong, by construction or by the second checker."""

from __future__ import annotations

import json
import sys
import tempfile
from collections import Counter
from pathlib import Path
from random import Random

from . import (
    tampers_at_once,
    tampers_false,
    tampers_forces,
    tampers_form,
    tampers_motion,
    tampers_scene,
    tampers_story,
)
from .checker import judge, read
from .draft import Draft
from .journal import Line, Record, Settings
from .kinds import KINDS, Kind, Unfit
from .plans import BASES, made, verdict

COUNT = 2400
SECONDS = 20.0
"""The budget of one verification; with what the issue allows beside it, 10 %."""
ATTEMPTS = 40
__all__ = [
    "run", "tampered", "tampers_at_once", "tampers_false", "tampers_forces", "tampers_form", "tampers_motion",
    "tampers_scene", "tampers_story",
]


def tampered(text: str, kind: Kind, seed: str) -> str | None:
    """The text of a spoilt plan; None where the plan has no place for such a change."""
    for attempt in range(3):
        draft = Draft(text, Random(f"{seed} {attempt}"))
        try:
            whole = kind.change(draft)
        except (Unfit, IndexError):
            continue
        changed = json.dumps(draft.data) if whole is None else whole
        if whole is not None or draft.data != json.loads(text):
            return changed
    return None


def cases(count: int, seed: int, bases: list[str]) -> list[str]:
    """Keys `kind/base/number`: every kind in turn, each on another base plan from one time to the next."""
    chance = Random(seed)
    orders = {name: chance.sample(bases, len(bases)) for name in KINDS}
    names = list(KINDS)
    return [
        f"{name}/{orders[name][turn % len(bases)]}/{turn // len(bases)}"
        for turn in range(count // len(names) + 1)
        for name in names
    ][:count]


def case(key: str, texts: dict[str, str], seed: int, file: Path) -> Record:
    """What becomes of one case: `wrong` is why the plan is not true, if it is known not to be."""
    name, base, _ = key.split("/")
    kind = KINDS[name]
    changed = None
    for other in [base, *sorted(texts)]:
        changed = tampered(texts[other], kind, f"{seed} {key}")
        if changed is not None:
            base = other
            break
    if changed is None:
        return {"said": "unfit"}
    file.write_text(changed, encoding="utf-8")
    found = {"base": base, **verdict(file, SECONDS)}
    if found["said"] in ("verified", "unfinished"):
        found["wrong"] = wrong(changed) or (["by construction"] if kind.false else [])
    return found


def wrong(text: str) -> list[str]:
    """What the second checker says against a plan."""
    try:
        plan = read(text)
    except (ValueError, RecursionError) as error:
        return [f"unreadable: {error}"[:200]]
    return [f"{f.kind}: {f.message} ({f.amount:.3g}, limit {f.limit:.3g})"[:240] for f in judge(plan)[:4]]


def base_texts(settings: Settings, names: list[str]) -> dict[str, str]:
    found = {}
    for name in names:
        file = made(BASES[name], settings.folder / "plans")
        if file is None:
            raise SystemExit(f"tamper: no plan of {BASES[name].key}; see its .answer in {settings.folder / 'plans'}")
        found[name] = file.read_text(encoding="utf-8")
    return found


def run(settings: Settings, bases: list[str] | None = None) -> list[Line]:
    names = list(BASES) if bases is None else bases
    texts = base_texts(settings, names)
    count = COUNT if settings.count is None else settings.count
    journal = settings.journal("tamper")
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "tampered.plan.json"
        keys = cases(count, settings.seed, names)
        records = list(journal.fill(keys, lambda key: case(key, texts, settings.seed, file)))
    return lines([r for r in records if r["said"] != "unfit"])


def lines(records: list[Record]) -> list[Line]:
    said = Counter(r["said"] for r in records)
    accepted = [r for r in records if r.get("wrong")]
    broken = [r for r in records if r["said"] == "traceback"]
    late = [r for r in records if r["said"] == "time" or r["cpu"] > 1.1 * SECONDS + 0.3]
    for record in [*accepted, *broken, *late]:
        print(f"tamper: {record}", file=sys.stderr)
    kinds, bases = {r["key"].split("/")[0] for r in records}, {r["base"] for r in records}
    true = said["verified"] + said["unfinished"] - len(accepted)
    what = f"{len(records)} tampered plans, {len(kinds)} kinds of change, {len(bases)} base plans"
    return [
        Line("tamper", what, f"{len(accepted)} wrong ones accepted ({true} stayed true)", not accepted),
        Line("tamper", what, f"{len(broken)} tracebacks, {len(late)} not within {SECONDS:g} s", not (broken or late)),
    ]
