"""The peer's side, run in its own process by a Python that has `robotic`: rai's KOMO on one case.

    python komo.py JOB.json RESULT.json

The job names the case, the bound ("seq", "path" or "path with collisions") and the seed. Bodies, rows, weights and
slices are those of tamplang's side: a foot stands on top of its stair, 3 cm from the edge; the crawler is at rest at
every switch.
"""

from __future__ import annotations

import json
import math
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np
import robotic as ry

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))
from peer import cases

EQUAL, BELOW, SQUARES = ry.OT.eq, ry.OT.ineq, ry.OT.sos
STIFF = 10.0
HINGES = ("j0", "j1", "j2", "j3", "j4", "j5", "footB")


def crawler_text(parent: str, collide: bool) -> str:
    """The crawler in rai's file format, standing on its end A on top of `parent`."""
    up = cases.STAIR[2] / 2 + cases.FOOT
    lines = [f'footA({parent}): {{ joint: rigid, Q: "t(0 0 {up})", shape: sphere, size: [{cases.FOOT}] }}']
    before, last = "footA", 0.0
    for name, axis, height, limit, home in zip(
        HINGES, cases.AXES, cases.JOINT_HEIGHTS, cases.LIMITS, cases.HOME, strict=True
    ):
        ball = f", shape: sphere, size: [{cases.FOOT}]" if name == "footB" else ""
        lines.append(
            f'{name}({before}): {{ joint: hinge{axis.upper()}, pre: "t(0 0 {height - last:.4f})",'
            f" limits: [{-limit},{limit}], q: {home}{ball} }}"
        )
        before, last = name, height
    contact = ", contact: -1" if collide else ""
    for i in range(6):
        length = cases.JOINT_HEIGHTS[i + 1] - cases.JOINT_HEIGHTS[i]
        lines.append(
            f'cap{i}({HINGES[i]}): {{ Q: "t(0 0 {length / 2:.4f})", shape: capsule,'
            f" size: [{length:.4f}, {cases.LINK_RADIUS}]{contact} }}"
        )
    return "\n".join(lines)


def box_text(name: str, at: tuple[float, ...] | list[float], size: tuple[float, ...], extra: str = "") -> str:
    place = " ".join(f"{v:.5f}" for v in at)
    sizes = ",".join(str(s) for s in (*size, 0.001))
    return f'{name}(world): {{ {extra}Q: "t({place})", shape: ssBox, size: [{sizes}] }}'


def scene_text(case: cases.Case, collide: bool) -> str:
    lines = ["world: {}"]
    if case.kind == "climb":
        contact = "contact: 1, " if collide else ""
        lines += [box_text(f"box{i}", at, cases.STAIR, contact) for i, at in enumerate(case.places)]
        lines.append(crawler_text("box0", collide))
    else:
        lines.append(box_text("base", (0.0, 0.0, cases.BASE[2] / 2), cases.BASE))
        lines.append(box_text("tray", cases.TRAY_AT, cases.TRAY))
        cube = (cases.ITEM,) * 3
        lines += [box_text(f"item{i}", at, cube, "joint: rigid, ") for i, at in enumerate(case.places)]
        lines.append(crawler_text("base", collide))
    return "\n".join(lines)


def inside(komo: Any, phase: int, thing: str, surface: str, half: tuple[float, float], height: float) -> None:
    """`thing` is `height` above the middle of `surface` at the end of the phase, and at most `half` aside."""
    komo.addObjective([phase], ry.FS.positionRel, [thing, surface], EQUAL, [[0, 0, STIFF]], [0, 0, height])
    for axis in (0, 1):
        for sign in (1.0, -1.0):
            scale, target = [[0.0, 0.0, 0.0]], [0.0, 0.0, 0.0]
            scale[0][axis], target[axis] = STIFF * sign, sign * half[axis]
            komo.addObjective([phase], ry.FS.positionRel, [thing, surface], BELOW, scale, target)


def add_steps(komo: Any, steps: int) -> None:
    half = (cases.STAIR[0] / 2 - cases.INSET, cases.STAIR[1] / 2 - cases.INSET)
    for k in range(1, steps + 1):
        foot = "footB" if k % 2 else "footA"
        komo.addModeSwitch([k, k + 1 if k < steps else -1], ry.SY.stable, [f"box{k}", foot], k == 1)
        inside(komo, k, foot, f"box{k}", half, cases.STAIR[2] / 2 + cases.FOOT)


def add_items(komo: Any, count: int) -> None:
    half = (cases.TRAY[0] / 2 - cases.TRAY_INSET, cases.TRAY[1] / 2 - cases.TRAY_INSET)
    for i in range(count):
        taken, item = 2 * i + 1, f"item{i}"
        komo.addModeSwitch([taken, taken + 1], ry.SY.stable, ["footB", item], True)
        komo.addObjective([taken], ry.FS.distance, ["footB", item], EQUAL, [STIFF])
        komo.addModeSwitch([taken + 1, -1], ry.SY.stable, ["tray", item], False)
        inside(komo, taken + 1, item, "tray", half, cases.TRAY[2] / 2 + cases.ITEM / 2)
        komo.addObjective([taken + 1], ry.FS.vectorZ, [item], EQUAL, [STIFF], [0.0, 0.0, 1.0])


def problem(config: Any, case: cases.Case, slices: int, collide: bool) -> Any:
    order = 1 if slices == 1 else 2
    komo = ry.KOMO(config, case.phases, slices, order, collide)
    # rai's cost is r², tamplang's r²/2
    komo.addControlObjective([], 0, (0.1 if slices == 1 else 0.2) * math.sqrt(0.5))
    komo.addControlObjective([], order, (0.3 if slices == 1 else 0.1) * math.sqrt(0.5))
    komo.addObjective([], ry.FS.jointLimits, [], BELOW, [1.0])
    if collide:
        komo.addObjective([], ry.FS.accumulatedCollisions, [], EQUAL, [1.0])
    komo.addQuaternionNorms()
    if case.kind == "climb":
        add_steps(komo, case.size)
    else:
        add_items(komo, case.size)
    if slices > 1:
        for k in range(1, case.phases + 1):
            komo.addObjective([k], ry.FS.qItself, [], EQUAL, [1.0], [], 1)
    return komo


def motion(config: Any, komo: Any, case: cases.Case) -> tuple[np.ndarray, np.ndarray]:
    """The crawler's rows (T + 1, 14) and the items' poses (T + 1, n, 7), read off the frames."""
    names = list(config.getFrameNames())
    frames = np.concatenate([config.getFrameState()[None], komo.getPathFrames()[:, : len(names)]])
    poses = np.concatenate([frames[..., :3], frames[..., 4:], frames[..., 3:4]], axis=-1)
    foot = poses[:, names.index("footA")]
    joints, before = [], foot[:, 3:]
    for name, axis in zip(HINGES, cases.AXES, strict=True):
        after = poses[:, names.index(name), 3:]
        component = "xyz".index(axis)
        joints.append(hinge(before, after, component))
        before = after
    crawler = np.column_stack([foot, *joints])
    items = [names.index(f"item{i}") for i in range(case.size if case.kind == "pick" else 0)]
    return crawler, poses[:, items]


def hinge(before: np.ndarray, after: np.ndarray, component: int) -> np.ndarray:
    """The angle about one axis between orientations (T, 4), unwrapped along the path."""
    v0, w0, v1, w1 = -before[:, :3], before[:, 3], after[:, :3], after[:, 3]
    vector = w0[:, None] * v1 + w1[:, None] * v0 + np.cross(v0, v1)
    angle = 2.0 * np.arctan2(vector[:, component], w0 * w1 - np.sum(v0 * v1, axis=1))
    return np.asarray((angle + np.pi) % (2 * np.pi) - np.pi)


def solve(komo: Any) -> tuple[Any, float]:
    started = time.process_time()
    result = ry.NLP_Solver(komo.nlp(), verbose=0).solve()
    return result, time.process_time() - started


def run(job: dict[str, Any]) -> dict[str, Any]:
    case = cases.Case(**job["case"])
    ry.rnd_seed(job["seed"])
    collide = job["bound"] == "path with collisions"
    with tempfile.NamedTemporaryFile("w", suffix=".g") as file:
        file.write(scene_text(case, collide))
        file.flush()
        config = ry.Config()
        config.addFile(file.name)
    solve(problem(config, cases.Case(case.kind, min(case.size, 1), 0, case.places), 1, False))  # warm caches
    started = time.process_time()
    komo = problem(config, case, 1, False)
    result, spent = solve(komo)
    sequence_cpu = cpu = time.process_time() - started
    slices = 1
    if job["bound"] != "seq":
        slices = cases.SLICES
        started = time.process_time()
        path = problem(config, case, slices, collide)
        path.initWithWaypoints(komo.getPath_qAll(), 1, True, 0.1, 0)
        result, spent = solve(path)
        komo, cpu = path, time.process_time() - started
    crawler, items = motion(config, komo, case)
    return {
        "cpu": cpu, "solver_cpu": spent, "sequence_cpu": sequence_cpu, "feasible": bool(result.feasible),
        "evaluations": int(result.evals), "slices": slices, "crawler": crawler.tolist(), "items": items.tolist(),
    }  # fmt: skip


if __name__ == "__main__":
    Path(sys.argv[2]).write_text(json.dumps(run(json.loads(Path(sys.argv[1]).read_text()))))
