"""Changes of the file itself: its text, fields, types, and numbers."""

from __future__ import annotations

import json
from typing import Any

from .draft import Draft
from .kinds import kind, need


def _text(draft: Draft) -> str:
    return json.dumps(draft.data)


def _numbers(draft: Draft) -> list[Any]:
    """A list of numbers somewhere in the motion."""
    track = draft.track()
    row: list[Any] = draft.chance.choice(track[draft.chance.choice(["poses", "joints"])])
    return row


@kind(false=True)
def truncated(draft: Draft) -> str:
    text = _text(draft)
    return text[: draft.chance.randrange(1, len(text) - 1)]


@kind(false=True)
def nested_brackets(draft: Draft) -> str:
    deep = draft.chance.choice([1000, 20000, 100000])
    return _text(draft)[:-1] + ', "statistics": ' + "[" * deep + "]" * deep + "}"


@kind(false=True)
def bracket_instead_of_a_list(draft: Draft) -> str:
    draft.data["times"] = "@"
    return _text(draft).replace('"@"', "[" * 100000)


@kind(false=True)
def not_json(draft: Draft) -> str:
    return draft.chance.choice(["", "null", "[]", "3", '"plan"', "{}", "\ufeff{}", "\x00" * 100, "{" * 50])


@kind(false=True)
def two_flags_of_one_name(draft: Draft) -> str:
    return _text(draft)[:-1] + ', "complete": true, "complete": true}'


@kind(false=True)
def two_goals_of_one_name(draft: Draft) -> str:
    return _text(draft).replace('"goal":', '"goal": "(nothing)", "goal":', 1)


@kind(false=True)
def not_a_number(draft: Draft) -> str:
    row = _numbers(draft)
    row[draft.chance.randrange(len(row))] = "@"
    return _text(draft).replace('"@"', draft.chance.choice(["NaN", "Infinity", "-Infinity"]))


@kind(false=True)
def number_of_400_digits(draft: Draft) -> str:
    row = _numbers(draft)
    row[draft.chance.randrange(len(row))] = "@"
    return _text(draft).replace('"@"', draft.chance.choice(["9" * 400, "1e999", "-" + "7" * 30000]))


@kind(false=True)
def huge_number(draft: Draft) -> None:
    row = _numbers(draft)
    row[draft.chance.randrange(len(row))] = draft.chance.choice([1e308, -1e200, 1e16])


@kind(false=True)
def huge_time(draft: Draft) -> None:
    draft.data["times"][-1] = draft.phases[-1]["end"] = draft.chance.choice([1e308, 1e12, 1e7])


@kind(false=True)
def number_as_text(draft: Draft) -> None:
    row = _numbers(draft)
    at = draft.chance.randrange(len(row))
    row[at] = str(row[at])


@kind(false=True)
def null_instead_of_a_value(draft: Draft) -> None:
    place = draft.chance.choice([draft.data, draft.data["task"], draft.phases[0], draft.data["modules"][0]])
    place[draft.chance.choice([k for k in place if k not in ("place", "verdict", "timing", "statistics")])] = None


@kind(false=True)
def field_missing(draft: Draft) -> None:
    places = [(draft.data, ["task", "modules", "bodies", "phases", "final_mode", "times", "tracks", "splines"])]
    places += [(draft.data["task"], ["name", "file", "parameters", "seed", "sources", "goal"])]
    places += [(draft.phases[0], ["rule", "args", "start", "end", "literals", "mode", "added"])]
    place, fields = draft.chance.choice(places)
    del place[draft.chance.choice(fields)]


@kind(false=True)
def foreign_field(draft: Draft) -> None:
    places = [draft.data, draft.data["task"], draft.phases[0], draft.data["modules"][0], draft.data["tracks"][0]]
    draft.chance.choice(places)[draft.chance.choice(["colour", "Complete", "torque", ""])] = 1


@kind(false=True)
def box_of_two_sizes(draft: Draft) -> None:
    shape = draft.chance.choice([b["shape"] for b in draft.data["bodies"]])
    shape["kind"], shape["size"] = "box", [0.3, 0.3]


@kind(false=True)
def negative_size(draft: Draft) -> None:
    size = draft.body()["shape"]["size"]
    size[0] = -size[0]


@kind(false=True)
def sizes_of_nothing(draft: Draft) -> None:
    draft.body()["shape"]["size"] = draft.chance.choice([[], [0.0], [0.1] * 5, [[0.1]], ["0.1"]])


@kind(false=True)
def unknown_format(draft: Draft) -> None:
    draft.data["format"] = draft.chance.choice(["tamplang-plan/0", "tamplang-plan/3", "plan", "TAMPLANG-PLAN/2", 2])


@kind()
def other_versions(draft: Draft) -> None:
    draft.data["versions"] = {"tamplang": "99.0"}


@kind()
def other_statistics(draft: Draft) -> None:
    draft.data["statistics"]["cost"] = -5.0


@kind()
def verdict_lies(draft: Draft) -> None:
    """Of no importance; what is wrong with a plan stays wrong, so that another change goes with it."""
    draft.data["verdict"] = {"verified": True, "worst": {}, "measures": [], "failures": [], "residuals": []}
    row = draft.chance.choice(draft.track()["joints"])
    row[0] += draft.chance.choice([0.0, 0.01])


@kind(false=True)
def degrees(draft: Draft) -> None:
    need(any(abs(v) > 0.01 for t in draft.data["tracks"] for row in t["joints"] for v in row))
    for track in draft.data["tracks"]:
        track["joints"] = [[v * 57.29577951308232 for v in row] for row in track["joints"]]
    for spline in draft.data["splines"]:
        spline["values"] = [[v * 57.29577951308232 for v in row] for row in spline["values"]]


@kind(false=True)
def millimetres(draft: Draft) -> None:
    for thing in [*draft.data["bodies"], *draft.data["modules"]]:
        thing["pose"][:3] = [1000 * v for v in thing["pose"][:3]]
    for track in [*draft.data["tracks"], *draft.data["body_tracks"]]:
        track["poses"] = [[1000 * v for v in p[:3]] + p[3:] for p in track["poses"]]


@kind(false=True)
def minutes(draft: Draft) -> None:
    draft.data["times"] = [t / 60 for t in draft.data["times"]]
