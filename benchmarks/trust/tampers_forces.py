"""Changes of what a plan tells of forces."""

from __future__ import annotations

from typing import Any

from .draft import Draft
from .kinds import kind, need

Data = dict[str, Any]
LOUD = 0.2
"""N or N m: what is at least told where a change of a share of it must be seen."""


def _told(draft: Draft) -> Data:
    need("statics" in draft.data)
    found: Data = draft.data["statics"]
    return found


@kind(false=True)
def torque_told_wrong(draft: Draft) -> None:
    records = [t for t in _told(draft)["torques"] if max(abs(v) for row in t["values"] for v in row) > LOUD]
    record = draft.chance.choice(records)
    most = max(abs(v) for row in record["values"] for v in row)
    at = draft.chance.randrange(len(record["values"][0]))
    by = most * draft.chance.choice([-0.5, 0.1, 3.0])
    record["values"] = [[v + by * (k == at) for k, v in enumerate(row)] for row in record["values"]]


@kind(false=True)
def torques_of_two_instants(draft: Draft) -> None:
    """What lies between them is told as straight."""
    records = [t for t in _told(draft)["torques"] if len(t["values"]) > 2]
    curved = [
        t for t in records
        if max(
            abs(t["values"][len(t["values"]) // 2][k] - (t["values"][0][k] + t["values"][-1][k]) / 2)
            for k in range(len(t["values"][0]))
        ) > 0.1 * max(abs(v) for row in t["values"] for v in row)
    ]  # fmt: skip
    record = draft.chance.choice(curved)
    record["values"] = [record["values"][0], record["values"][-1]]


@kind(false=True)
def torques_left_out(draft: Draft) -> None:
    told = _told(draft)
    told["torques"].remove(draft.chance.choice(told["torques"]))


@kind(false=True)
def load_told_wrong(draft: Draft) -> None:
    """Every row of a pair, so that its motion does not matter."""
    record = draft.chance.choice(_told(draft)["wrenches"])
    at, most = draft.chance.randrange(6), max(abs(v) for row in record["values"] for v in row)
    by = max(LOUD, draft.chance.choice([-0.5, 0.2, 2.0]) * most, key=abs)
    record["values"] = [[v + by * (k == at) for k, v in enumerate(row)] for row in record["values"]]


@kind(false=True)
def load_told_twice(draft: Draft) -> None:
    told = _told(draft)
    told["wrenches"].append(dict(draft.chance.choice(told["wrenches"])))


@kind(false=True)
def load_left_out(draft: Draft) -> None:
    told = _told(draft)
    told["wrenches"].remove(draft.chance.choice(told["wrenches"]))


@kind(false=True)
def load_of_another_pair(draft: Draft) -> None:
    record = draft.chance.choice(_told(draft)["wrenches"])
    field = draft.chance.choice(["between", "manner", "at", "radius", "phase"])
    record[field] = {
        "between": ["nobody", record["between"][1]], "manner": "nothing", "at": "nobody",
        "radius": record["radius"] + 0.01, "phase": record["phase"] + 1000,
    }[field]  # fmt: skip


@kind(false=True)
def load_the_other_way_round(draft: Draft) -> None:
    record = draft.chance.choice([w for w in _told(draft)["wrenches"] if abs(w["values"][0][2]) > LOUD])
    record["between"] = record["between"][::-1]


@kind(false=True)
def strength_told_wrong(draft: Draft) -> None:
    told = _told(draft)
    record = draft.chance.choice([*told["drives"], *told["holds"]])
    field = draft.chance.choice([k for k, v in record.items() if isinstance(v, float) and v > 0.0])
    record[field] = record[field] * draft.chance.choice([0.9, 1.1])


@kind(false=True)
def weight_told_wrong(draft: Draft) -> None:
    record = draft.chance.choice([w for w in _told(draft)["weights"] if w["mass"] > 0.0])
    match draft.chance.choice(["mass", "centre", "inertia"]):
        case "mass":
            record["mass"] *= 1.01
        case "centre":
            record["centre"][draft.chance.randrange(3)] += 0.01
        case _:
            record["inertia"] = [2.0 * v + 1e-3 for v in record["inertia"]]


@kind(false=True)
def safety_told_wrong(draft: Draft) -> None:
    _told(draft)["safety"] *= draft.chance.choice([0.5, 1.2])
