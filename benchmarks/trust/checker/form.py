"""A plan file as records: no field too many or too few, finite numbers, and format 1 brought up to format 2."""

from __future__ import annotations

import base64
import json
import math
from collections.abc import Iterator
from typing import Any

Record = dict[str, Any]
LITERAL = {"predicate": "text", "args": ["text"], "place": "place?"}
SHAPE = {"kind": "text", "size": ["number"]}
POSE = ["number"]
SCHEMA: Record = {
    "format": "text", "needs?": ["text"], "versions": "any",
    "task": {
        "name": "text", "file": "text", "parameters": "any", "seed": "number", "goal": "text",
        "sources": [{"path": "text", "text": "text", "sha256": "text"}],
        "files?": [{"path": "text", "data": "text", "sha256": "text"}],
    },
    "modules": [{
        "name": "text", "type": "text", "pose": POSE, "start": ["number"],
        "joints": [{
            "name": "text", "kind": "text", "parent": "number", "placement": POSE, "axis": ["number"],
            "lower": "number", "upper": "number", "speed": "number", "acceleration?": "number",
            "follows?": [None, {"leader": "number", "factor": "number", "offset": "number"}],
            "passive?": "flag", "jerk?": "number",
        }],
        "effectors": [{"name": "text", "joint": "number", "placement": POSE, "shape": [None, SHAPE]}],
        "links": [{"joint": "number", "placement": POSE, "shape": SHAPE}],
    }],
    "bodies": [{"name": "text", "type": "text", "shape": SHAPE, "pose": POSE, "movable": "flag", "collides?": "flag"}],
    "phases": [{
        "action": "text", "rule": "text", "args": "any", "place": "place?", "start": "number", "end": "number",
        "literals": [LITERAL], "mode": [LITERAL], "added": [LITERAL], "completed?": "flag",
    }],
    "final_mode": [LITERAL],
    "times": ["number"],
    "tracks": [{"name": "text", "poses": [POSE], "joints": [["number"]]}],
    "body_tracks": [{"name": "text", "first": "number", "poses": [POSE]}],
    "splines": [{"module": "text", "from": "number", "until": "number", "knots": ["number"], "values": [["number"]]}],
    "statistics": "any", "timing?": "any", "verdict?": "any",
    "courses?": [{"body": "text", "start": "number", "points": [["number"]], "speed": "number", "returns": "flag"}],
    "breakdowns?": [{"module": "text", "time": "number", "kind": "text"}],
    "windows?": [{
        "time": "number", "phase": "number", "reason": "text", "actions": ["text"], "motions": "number",
        "unmet": ["text"],
    }],
    "statics?": {
        "weights": [{"name": "text", "joint": "number", "mass": "number", "centre": ["number"], "inertia": ["number"]}],
        "drives": [{
            "module": "text", "joint": "text", "torque": "number", "bearing": "number", "rotor": "number",
            "brake?": "number",
        }],
        "torques": [{"module": "text", "phase": "number", "values": [["number"]]}],
        "holds?": [{
            "name": "text", "manner": "text", "force": "number", "shear": "number", "moment": "number",
            "twist": "number", "friction": "number",
        }],
        "wrenches?": [{
            "between": ["text"], "manner": "text", "at": "text", "radius": "number", "phase": "number",
            "values": [["number"]],
        }],
        "safety?": "number",
    },
    "complete?": "flag",
}  # fmt: skip
KNOWN = {
    "statistics": {
        "tree_nodes", "expanded_nodes", "optimal", "gap", "cost", "path_cost", "path_cost_before", "bounds",
        "refusals", "tree", "seconds", "objective",
    },
    "verdict": {"verified", "worst", "measures", "failures", "residuals", "goal_reached", "unmet", "at_rest"},
    "timing": {"seconds", "windows", "machine"},
}  # fmt: skip


def read(text: str) -> Record:
    """The object of a plan file. Raises ValueError where it is no JSON, or a name stands twice in an object."""
    found = json.loads(text, object_pairs_hook=_once, parse_constant=_foreign)
    if not isinstance(found, dict):
        raise ValueError("a plan is an object")
    return found


def _once(pairs: list[tuple[str, Any]]) -> Record:
    found = dict(pairs)
    if len(found) < len(pairs):
        raise ValueError("a name stands twice in an object")
    return found


def _foreign(name: str) -> float:
    raise ValueError(f"JSON has no {name}")


def upgraded(plan: Record) -> Record:
    """The records of format 2. Raises ValueError where fields are not those of the format."""
    if plan["format"] not in ("tamplang-plan/1", "tamplang-plan/2"):
        raise ValueError(f"no format of a plan: {plan['format']!r:.40}")
    plan = dict(plan)
    if plan["format"] == "tamplang-plan/1":
        plan["splines"] = [_only(s, {"from": s["phase"], "until": s["phase"]}, "phase") for s in plan["splines"]]
        plan["body_tracks"] = [{"first": 0, **t} for t in plan["body_tracks"]]
        told = plan["task"]["sources"]
        texts, files = ([s for s in told if s["path"].endswith(".tamp") is text] for text in (True, False))
        carried = [_only(f, {"data": base64.b64encode(f["text"].encode()).decode()}, "text") for f in files]
        plan["task"] = {**plan["task"], "sources": texts, "files": carried}
        plan["windows"] = [_only(w, {}, "seconds") for w in plan.get("windows", [])]
    wrong = next(_unfit(SCHEMA, plan, "plan"), None)
    if wrong is not None:
        raise ValueError(wrong)
    if set(plan.get("needs") or ()) - {"couplings", "passive", "jerk", "places", "statics"}:
        raise ValueError(f"it needs {plan['needs']!r:.40}")
    for field, known in KNOWN.items():
        if isinstance(plan.get(field), dict) and not set(plan[field]) <= known:
            raise ValueError(f"{field} has fields that the page does not know")
    return {"courses": [], "breakdowns": [], "windows": [], "complete": True, **plan}


def _only(record: Record, more: Record, without: str) -> Record:
    return {**{k: v for k, v in record.items() if k != without}, **more}


def _unfit(schema: Any, found: Any, where: str) -> Iterator[str]:
    """Where an object is not as the page says."""
    if isinstance(schema, dict):
        if not isinstance(found, dict):
            yield f"{where} is no object"
            return
        fields = {name.removesuffix("?"): part for name, part in schema.items()}
        needed = {name for name in schema if not name.endswith("?")}
        for name in sorted(needed - set(found)):
            yield f"{where} lacks {name}"
        for name in sorted(set(found) - set(fields)):
            yield f"{where} has {name!r:.40}, which the page does not know"
        for name in set(found) & set(fields):
            yield from _unfit(fields[name], found[name], f"{where}.{name}")
    elif isinstance(schema, list) and schema[0] is None:
        if found is not None:
            yield from _unfit(schema[1], found, where)
    elif isinstance(schema, list):
        if not isinstance(found, list):
            yield f"{where} is no list"
        elif schema[0] == "number":
            if not all(_number(v) for v in found):
                yield f"{where} holds what is no finite number"
        else:
            for number, part in enumerate(found):
                yield from _unfit(schema[0], part, f"{where}[{number}]")
    elif not _fits(schema, found):
        yield f"{where} is no {schema}"


def _fits(kind: str, found: Any) -> bool:
    if kind == "number":
        return _number(found)
    if kind == "place?":
        return found is None or (isinstance(found, dict) and set(found) == {"file", "line", "column"})
    return kind == "any" or isinstance(found, {"text": str, "flag": bool}[kind])


def _number(value: Any) -> bool:
    """Numbers beyond 1e12 are not those of a plan."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return abs(value) <= 1e12 and math.isfinite(value)
