"""Plans made by hand for the tests: a walk up some steps by one module, and two modules that dock."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from functools import cache

import numpy as np

from tamplang.runtime.geometry.transforms import Array, compose, rotate
from tamplang.runtime.plan import (
    FORMAT,
    BodyRecord,
    BodyTrackRecord,
    BoundRecord,
    EffectorRecord,
    FailureRecord,
    JointRecord,
    LinkRecord,
    LiteralRecord,
    MeasureRecord,
    ModuleRecord,
    PhaseRecord,
    PlaceRecord,
    Plan,
    RefusalRecord,
    SearchNode,
    ShapeRecord,
    SourceRecord,
    StatisticsRecord,
    TaskRecord,
    TimingRecord,
    TrackRecord,
    VerdictRecord,
)
from tamplang.runtime.report.kinematics import joint_frames

CENTRES = [0.0, 0.15, 0.325, 0.5, 0.675, 0.85, 1.0]
HOME = [0.0, 0.3, 0.0, -0.6, 0.0, 0.3, 0.0]
SAMPLES = 40
IDENTITY = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]

TASK = """import std.rules

## One module climbs, and takes what lies at the top.
task climb(n: int = 3) {
    scene stairs(n)   # <n> steps & a floor
    goal (held target)
}
"""
RULES = """## A lone module sets its free foot B down on Y and lifts A from X.
rule step(A B: effector, X Y: base) {
    pre   (support A), (linked A B), (free B), (on X A)
    post  not (support A), [stable Y B], [stand B Y]
}

## The free end A takes X.
rule grasp(A: effector, X: object) {
    pre   (free A), (grippable X)
    post  (grasped A X), [stable A X], [touch A X]
}

rule connect(p q: chain of module by connected) {
    post  [stable q.last p.first]
}
"""
MOTION = """motion [stand X: effector, Y: object] {
    at switch bottom(X) = top(Y)
    at switch inside(X, Y) >= 0.03 m
}
"""


def crawler(name: str, pose: list[float]) -> ModuleRecord:
    """Seven joints z y z y z y z over a metre, a ball at both ends."""
    joints, links = [], []
    for index, (centre, axis) in enumerate(zip(CENTRES, "zyzyzyz", strict=True)):
        rise = centre - (CENTRES[index - 1] if index else 0.0)
        limit, vector = (3.1, [0.0, 0.0, 1.0]) if axis == "z" else (2.1, [0.0, 1.0, 0.0])
        placement = [0.0, 0.0, rise, 0.0, 0.0, 0.0, 1.0]
        joints.append(
            JointRecord(f"j{index + 1}", "revolute", index - 1, placement, vector, -limit, limit, 2.0)
        )
        if index:
            middle = [0.0, 0.0, rise / 2, 0.0, 0.0, 0.0, 1.0]
            links.append(LinkRecord(index - 1, middle, ShapeRecord("capsule", [0.04, rise])))
    ball = ShapeRecord("sphere", [0.05])
    ends = [EffectorRecord("A", -1, [0.0, 0, 0, 1, 0, 0, 0], ball), EffectorRecord("B", 6, IDENTITY, ball)]
    return ModuleRecord(name, "crawler", joints, ends, links, pose, HOME)


def inverse(pose: Array) -> Array:
    """Inverse of poses `(T, 7)`."""
    turn = pose[:, 3:] * [-1.0, -1.0, -1.0, 1.0]
    return np.concatenate([-rotate(turn, pose[:, :3]), turn], axis=1)


def tip(module: ModuleRecord, base: Array, joints: Array) -> Array:
    return joint_frames(module, np.broadcast_to(base, (len(joints), 7)), joints)[-1]


def reach(module: ModuleRecord, stand: Array, at_tip: bool, target: Sequence[float], start: Array) -> Array:
    """Joint values `(7,)` that bring the free end to `target`; the other end stands at `stand` `(1, 7)`."""
    joints = start.copy()

    def free_end(values: Array) -> Array:
        relative = tip(module, np.array([IDENTITY]), values)
        return compose(stand, inverse(relative) if at_tip else relative)[:, :3]

    for _ in range(60):
        ends = free_end(np.vstack([joints, joints + 1e-5 * np.eye(7)]))
        slope = (ends[1:] - ends[0]).T / 1e-5
        step = slope.T @ np.linalg.solve(slope @ slope.T + 1e-3 * np.eye(3), np.array(target) - ends[0])
        joints += np.clip(step, -0.2, 0.2) + 0.002 * (np.array(HOME) - joints)
    return joints


def blend(first: Array, last: Array) -> Array:
    share = np.linspace(0.0, 1.0, SAMPLES + 1)[:, None]
    share = share * share * (3.0 - 2.0 * share)
    return first + share * (last - first)


def place(file: str, line: int) -> PlaceRecord:
    return PlaceRecord(file, line, 1)


def stand_literals(foot: str, surface: str) -> list[LiteralRecord]:
    return [
        LiteralRecord("stable", [surface, foot], place("std/motion.tamp", 1)),
        LiteralRecord("stand", [foot, surface], place("std/motion.tamp", 2)),
    ]


def sources() -> list[SourceRecord]:
    texts = {"examples/climb.tamp": TASK, "std/rules.tamp": RULES, "std/motion.tamp": MOTION}
    return [SourceRecord(p, t, hashlib.sha256(t.encode()).hexdigest()) for p, t in texts.items()]


def statistics(actions: list[str]) -> StatisticsRecord:
    tree = [SearchNode(0, -1, "", float(len(actions)), "expanded")]
    parent = 0
    for depth, action in enumerate(actions):
        for number in range(3):
            action_here = action if number == 0 else f"{action} variant {number}"
            status = "pruned: reach" if number == 2 else "expanded" if depth < len(actions) - 1 else "refused"
            tree.append(SearchNode(len(tree), parent, action_here, len(actions) + 0.5 * number, status))
        parent = len(tree) - 3
    refusal = RefusalRecord(
        "path",
        [*actions[:-1], f"{actions[-1]} variant 1"],
        "c[1] meets stair[2]",
        0.013,
        "m",
        place("std/rules.tamp", 4),
    )
    bounds = [
        BoundRecord("seq", 4, 1),
        BoundRecord("seq-path", 3, 1),
        BoundRecord("path", 1, 1),
    ]
    return StatisticsRecord(120, 17, True, None, 31.4, bounds, [refusal], tree)


def timing() -> TimingRecord:
    return TimingRecord(
        {
            "compile": 0.21,
            "search": 0.02,
            "seq": 0.31,
            "seq_path": 1.2,
            "path": 2.4,
            "verify": 0.4,
            "total": 4.61,
        }
    )


def verdict(phases: list[PhaseRecord]) -> VerdictRecord:
    measures = [
        MeasureRecord("slip", 0.00021, 0.002, "m", 3.2, ["c[1].A", "ground"], place("std/motion.tamp", 1)),
        MeasureRecord("penetration", 0.0, 0.001, "m", 1.1, ["c[1]", "stair[1]"]),
        MeasureRecord("joint limit", 0.0001, 0.01, "rad", 2.0, ["c[1]"]),
    ]
    residuals = [
        MeasureRecord(
            f"[{a.predicate} {' '.join(a.args)}]", 1e-5 * (i + 1), 0.002, "m", p.end, a.args, a.place
        )
        for i, p in enumerate(phases)
        for a in p.added
    ]
    return VerdictRecord(True, {"slip_m": 0.00021}, measures, [], residuals, goal_reached=True)


def stair_pose(index: int) -> list[float]:
    return [0.35 * index, 0.0, 0.2 * index, 0.0, 0.0, 0.0, 1.0]


def stair_bodies(count: int) -> list[BodyRecord]:
    bodies = [
        BodyRecord("ground", "base", ShapeRecord("box", [2.0, 2.0, 0.05]), [-0.9, 0, 0, 0, 0, 0, 1], False)
    ]
    for index in range(1, count + 1):
        box = ShapeRecord("box", [0.3, 0.8, 0.05])
        bodies.append(BodyRecord(f"stair[{index}]", "base", box, stair_pose(index), False))
    return bodies


def stamps(phases: int) -> list[float]:
    """Both sides of every switch, phases of one second."""
    return [k + s / SAMPLES for k in range(phases) for s in range(SAMPLES + 1)]


@cache
def climb_plan(count: int = 3) -> Plan:
    """One module steps from the floor up `count` stairs, grasps the target and lifts it a little."""
    module = crawler("c[1]", [-0.2, 0.0, 0.075, 0.0, 0.0, 0.0, 1.0])
    feet = [[-0.2, 0.0, 0.075]] + [[p[0], 0.0, p[2] + 0.075] for p in map(stair_pose, range(1, count + 1))]
    target = [0.35 * count + 0.25, 0.15, 0.2 * count + 0.6]
    joints, base = np.array(HOME), np.array([module.pose])
    poses: list[list[float]] = []
    values: list[list[float]] = []
    held: list[list[float]] = []
    phases: list[PhaseRecord] = []
    mode = stand_literals("c[1].A", "ground")
    for index in range(count + 2):
        on_tip = index % 2 == 1 if index <= count else (count % 2 == 1)
        foot, free = ("c[1].B", "c[1].A") if on_tip else ("c[1].A", "c[1].B")
        stand = tip(module, base, joints[None]) if on_tip else base
        goal = (
            feet[index + 1]
            if index < count
            else target
            if index == count
            else [target[0], -0.1, target[2] + 0.2]
        )
        end = reach(module, stand, on_tip, goal, joints)
        path = blend(joints, end)
        rel = tip(module, np.array([IDENTITY]), path)
        track = compose(stand, inverse(rel)) if on_tip else np.repeat(base, len(path), axis=0)
        tips = compose(track, rel)
        hand = tips if free.endswith("B") else track
        held += [
            [*hand[i, :3].tolist(), 0, 0, 0, 1] if index > count else [*target, 0, 0, 0, 1] for i in range(len(path))
        ]
        poses += track.tolist()
        values += path.tolist()
        rule, args, line = "grasp", [free, "target"], 8
        added = (
            [LiteralRecord("stable", [free, "target"], place("std/rules.tamp", 10))] if index == count else []
        )
        if index < count:
            surface = f"stair[{index + 1}]"
            rule, args, line = "step", [foot, free, "ground" if index == 0 else f"stair[{index}]", surface], 2
            added = stand_literals(free, surface)
        logic = [LiteralRecord("support", [foot], place("std/rules.tamp", 3))]
        record = PhaseRecord(
            f"{rule}({', '.join(args)})",
            rule,
            args,
            place("std/rules.tamp", line),
            float(index),
            float(index + 1),
            logic,
            mode,
            added,
        )
        phases.append(record)
        mode = added if index < count else mode + added
        base, joints = track[-1:], end
    bodies = [
        *stair_bodies(count),
        BodyRecord("target", "object", ShapeRecord("sphere", [0.04]), [*target, 0, 0, 0, 1], True),
    ]
    task = TaskRecord(
        "climb", "examples/climb.tamp", {"n": count, "crawlers": 1}, 0, sources(), "(held target)"
    )
    return Plan(
        FORMAT,
        {"tamplang": "0.1.0"},
        task,
        [module],
        bodies,
        phases,
        mode,
        stamps(len(phases)),
        [TrackRecord("c[1]", poses, values)],
        [BodyTrackRecord("target", 0, held)],
        [],
        statistics([p.action for p in phases]),
        verdict(phases),
        timing=timing(),
    )


@cache
def dock_plan() -> Plan:
    """Two modules on the floor: the first bends over, docks to the second, is lifted and carried round."""
    first = crawler("c[1]", [-0.2, -0.3, 0.075, 0.0, 0.0, 0.0, 1.0])
    second = crawler("c[2]", [-0.2, 0.3, 0.075, 0.0, 0.0, 0.0, 1.0])
    rest = np.array(HOME)
    bent = np.array([-1.57, 0.4, 0.0, 0.7, 0.0, 0.5, 0.0])
    turned = np.array([1.2, 0.9, 0.3, -0.2, 0.0, 0.4, 1.0])
    ways = [[(rest, rest), (rest, bent)], [(rest, rest), (bent, turned)], [(rest, bent), (turned, rest)]]
    one: list[list[float]] = []
    two: list[list[float]] = []
    joints: list[list[list[float]]] = [[], []]
    link: Array | None = None
    for way in ways:
        paths = [blend(*pair) for pair in way]
        bases = np.repeat([second.pose], SAMPLES + 1, axis=0)
        tips = tip(second, np.array([second.pose]), paths[1])
        track = np.repeat([first.pose], SAMPLES + 1, axis=0)
        if link is None:
            link = compose(inverse(tips[-1:]), tip(first, track[-1:], paths[0][-1:]))
        else:
            track = compose(compose(tips, link), inverse(tip(first, np.array([IDENTITY]), paths[0])))
        one += track.tolist()
        two += bases.tolist()
        for values, path in zip(joints, paths, strict=True):
            values += path.tolist()
    apart = stand_literals("c[1].A", "ground") + stand_literals("c[2].A", "ground")
    docked = [LiteralRecord("stable", ["c[2].B", "c[1].B"], place("std/rules.tamp", 14))]
    joined = stand_literals("c[2].A", "ground") + docked
    rules = [("connect", 13, apart, docked), ("swing", 13, joined, []), ("swing", 13, joined, [])]
    phases = [
        PhaseRecord(
            f"{r}([c[1].A c[1].B], [c[2].B c[2].A])",
            r,
            ["[c[1].A c[1].B]", "[c[2].B c[2].A]"],
            place("std/rules.tamp", line),
            float(i),
            float(i + 1),
            [],
            mode,
            added,
        )
        for i, (r, line, mode, added) in enumerate(rules)
    ]
    worse = FailureRecord("slip", "c[1].B slides on c[2].B", 0.0041, "m", 1.5, place("std/rules.tamp", 14))
    refused = VerdictRecord(
        False, {"slip_m": 0.0041}, [MeasureRecord("slip", 0.0041, 0.002, "m", 1.5)], [worse], []
    )
    return Plan(
        FORMAT,
        {"tamplang": "0.1.0"},
        TaskRecord("dock", "dock.tamp", {}, 3, sources(), "(connected c[1].B c[2].B)"),
        [first, second],
        stair_bodies(2),
        phases,
        joined,
        stamps(3),
        [TrackRecord("c[1]", one, joints[0]), TrackRecord("c[2]", two, joints[1])],
        [],
        [],
        StatisticsRecord(gap=1.0),
        refused,
    )


def empty_plan() -> Plan:
    """The least that a plan can hold."""
    task = TaskRecord("nothing", "nothing.tamp", {}, 0, [], "")
    return Plan(FORMAT, {}, task, [], [], [], [], [], [], [], [], StatisticsRecord())


def still_plan() -> Plan:
    """A scene without phases, tracks, verdict or tree."""
    task = TaskRecord("still", "still.tamp", {}, 0, [], "")
    module = crawler("c[1]", [-0.2, 0.0, 0.075, 0.0, 0.0, 0.0, 1.0])
    return Plan(FORMAT, {}, task, [module], stair_bodies(2), [], [], [], [], [], [], StatisticsRecord())
