"""What a plan was made for: its sources compiled anew, and whether its records are those of the scene."""

from __future__ import annotations

import base64
import hashlib
import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from tamplang.compiler import ir
from tamplang.compiler.imports import load_sources
from tamplang.compiler.pipeline import compile_sources
from tamplang.langs import syntax
from tamplang.langs.source import Source

UNITS = {"int": "", "real": "", "length": " m", "angle": " rad", "time": " s", "speed": " m/s", "mass": " kg",
         "density": " kg/m^3", "force": " N", "torque": " N m", "inertia": " kg m^2"}
SAME = 1e-6


def compiled(task: dict[str, Any]) -> ir.Problem:
    """The problem that the sources, parameters and seed of a plan say. Raises ValueError, SourceError, UsageError."""
    told, carried = task["sources"], task.get("files", [])
    for some in (told, carried):
        if len({s["path"] for s in some}) < len(some):
            raise ValueError("two sources have the same path")
        for entry in some:
            if hashlib.sha256(_bytes(entry)).hexdigest() != entry["sha256"]:
                raise ValueError(f"{entry['path']} is not what its hash says")
    if task["file"] != told[0]["path"]:
        raise ValueError("the task is of another file")
    sources = [Source(s["path"], s["text"]) for s in told]
    files = {f["path"]: _bytes(f) for f in carried}
    library = load_sources(sources, files)[0]
    declared = library.tasks[task["name"]].parameters
    types = {p.name: p.type.name for p in declared if isinstance(p.type, syntax.NamedType)}
    given = task["parameters"]
    if set(given) != set(types):
        raise ValueError("the parameters are not those of the task")
    if any(isinstance(v, bool) or not isinstance(v, int | float) for v in given.values()):
        raise ValueError("a parameter is no number")
    texts = {name: f"{value!r}{UNITS[types[name]]}" for name, value in given.items()}
    problem = compile_sources(sources, task["name"], texts, task["seed"], files)[0]
    idle = {s.path for s in sources} - {s.path for s in problem.sources} | set(files) - set(problem.files)
    if idle:
        raise ValueError(f"nothing names {', '.join(sorted(idle))}")
    return problem


def _bytes(entry: dict[str, Any]) -> bytes:
    return str(entry["text"]).encode() if "text" in entry else base64.b64decode(entry["data"], validate=True)


def differences(problem: ir.Problem, plan: dict[str, Any]) -> Iterator[str]:
    """Where the records of modules and bodies are not those of the compiled scene."""
    modules = {m["name"]: m for m in plan["modules"]}
    bodies = {b["name"]: b for b in plan["bodies"]}
    if len(modules) < len(plan["modules"]) or len(bodies) < len(plan["bodies"]):
        yield "two things have the same name"
    if set(modules) != set(problem.world.modules) or set(bodies) != set(problem.world.bodies):
        yield "modules and bodies are not those of the scene"
        return
    for name, module in problem.world.modules.items():
        yield from (f"{name}: {what}" for what in _unlike(_module(module), modules[name]))
    for name, body in problem.world.bodies.items():
        wanted = {"type": body.type, "shape": _shape(body.shape), "pose": list(body.pose), "movable": body.movable}
        yield from (f"{name}: {what}" for what in _unlike(wanted, bodies[name]))
        if bodies[name].get("collides", True) != body.collides:
            yield f"{name}: whether it can be collided with"

    courses, breakdowns = _happening(problem)
    for what, records in (("courses", courses), ("breakdowns", breakdowns)):
        key = "body" if what == "courses" else "module"
        found = sorted(plan[what], key=lambda x: (x[key], x.get("start", x.get("time"))))
        if found:
            yield from (f"{what}: {w}" for w in _unlike(records, found))


def _happening(problem: ir.Problem) -> tuple[list[dict[str, Any]], list[dict[str, Any]]]:
    """What moves and fails on its own in the scene, as records of a plan. A plan may tell none of it."""
    courses = [
        {
            "body": c.body,
            "start": c.start,
            "points": [list(p) for p in c.points],
            "speed": c.speed,
            "returns": c.returns,
        }
        for c in sorted(problem.world.courses, key=lambda c: (c.body, c.start))
    ]
    breakdowns = [
        {"module": b.module, "time": b.time, "kind": b.kind}
        for b in sorted(problem.world.breakdowns, key=lambda b: (b.module, b.time))
    ]
    return courses, breakdowns


def _module(module: ir.Module) -> dict[str, Any]:
    kind = module.type
    joints = [
        {
            "name": j.name, "kind": j.kind, "parent": j.parent, "placement": list(j.placement), "axis": list(j.axis),
            "lower": max(j.lower, -1e9), "upper": min(j.upper, 1e9), "speed": min(j.speed, 1e9),
            "acceleration": min(j.acceleration, 1e9),
            **({"passive": True} if j.passive else {}),
            **({"jerk": j.jerk} if math.isfinite(j.jerk) else {}),
            **({} if j.follows is None else {"follows": _coupling(j.follows)}),
        }
        for j in kind.joints
    ]  # fmt: skip
    ends = [
        {"name": e.name, "joint": e.joint, "placement": list(e.placement), "shape": _shape(e.shape)}
        for e in kind.effectors
    ]
    links = [{"joint": e.joint, "placement": list(e.placement), "shape": _shape(e.shape)} for e in kind.links]
    return {
        "type": kind.name, "joints": joints, "effectors": ends, "links": links, "pose": list(module.pose),
        "start": list(module.joints),
    }  # fmt: skip


def _coupling(coupling: ir.Coupling) -> dict[str, float]:
    return {"leader": coupling.leader, "factor": coupling.factor, "offset": coupling.offset}


def _shape(shape: ir.Shape | None) -> dict[str, Any] | None:
    return None if shape is None else {"kind": shape.kind, "size": list(shape.size)}


def _unlike(wanted: Any, found: Any) -> Iterator[str]:
    """Where records differ, numbers by more than rounding."""
    if isinstance(wanted, dict) and isinstance(found, dict):
        for key, value in wanted.items():
            if key not in found:
                yield f"no {key}"
            elif key not in ("pose", "placement") or not _same_pose(value, found[key]):
                yield from (f"{key}: {what}" for what in _unlike(value, found[key]))
    elif isinstance(wanted, list) and isinstance(found, list) and len(wanted) == len(found):
        for number, (one, other) in enumerate(zip(wanted, found, strict=True)):
            yield from (f"{number}: {what}" for what in _unlike(one, other))
    elif isinstance(wanted, bool) or isinstance(found, bool) or not isinstance(wanted, int | float):
        if wanted is not found and wanted != found:
            yield f"{found!r:.40} instead of {wanted!r:.40}"
    elif not isinstance(found, int | float) or abs(found - wanted) > SAME * max(1.0, abs(wanted)):
        yield f"{found!r:.40} instead of {wanted!r:.40}"


def _same_pose(wanted: list[float], found: Any) -> bool:
    """The sign of a quaternion is of no meaning."""
    if not isinstance(found, list) or len(found) != 7:
        return False
    one, other = np.array(wanted), np.array(found, dtype=float)
    turned = min(np.abs(one[3:] - other[3:]).max(), np.abs(one[3:] + other[3:]).max())
    return bool(np.abs(one[:3] - other[:3]).max() <= SAME and turned <= SAME)


def centre_of(body: dict[str, Any], courses: list[dict[str, Any]], times: Any) -> Any:
    """The centre (T, 3) of a body that follows its courses, at every time."""
    own = sorted((c for c in courses if c["body"] == body["name"]), key=lambda c: c["start"])
    at = np.tile(np.array(body["pose"][:3], dtype=float), (len(times), 1))
    begin = at[0].copy()
    for number, course in enumerate(own):
        until = own[number + 1]["start"] if number + 1 < len(own) else np.inf
        here = times >= course["start"]
        at[here] = _along(begin, course, times[here] - course["start"])
        if np.isfinite(until):
            begin = _along(begin, course, np.array([until - course["start"]]))[0]
    return at


def _along(begin: Any, course: dict[str, Any], gone: Any) -> Any:
    points = np.vstack([begin, np.array(course["points"], dtype=float)])
    legs = np.linalg.norm(np.diff(points, axis=0), axis=1)
    ways = np.concatenate([[0.0], np.cumsum(legs)])
    if course["speed"] == 0 or ways[-1] == 0:
        return np.tile(points[-1], (len(gone), 1))
    way = course["speed"] * gone
    if course["returns"]:
        way = way % (2 * ways[-1])
        way = np.minimum(way, 2 * ways[-1] - way)
    way = np.minimum(way, ways[-1])
    kept = np.concatenate([[True], legs > 0])
    return np.column_stack([np.interp(way, ways[kept], points[kept, k]) for k in range(3)])
