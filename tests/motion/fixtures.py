"""Hand-built problems and skeletons of the motion layer: a crawler with seven joints on stairs and at a table."""

from __future__ import annotations

import math
import random

from tamplang.compiler.ir import (
    Action,
    And,
    Arith,
    Body,
    Chain,
    Effect,
    Effector,
    Function,
    Joint,
    Letter,
    Link,
    Literal,
    Module,
    ModuleType,
    MotionPredicate,
    Number,
    ObjectType,
    Options,
    Problem,
    Row,
    Rule,
    Shape,
    Term,
    Var,
    Variable,
    Vector,
    World,
)
from tamplang.runtime.skeleton import Phase, Skeleton

X, Y = Var("X"), Var("Y")
VARIABLES = (Variable("X", ObjectType("object")), Variable("Y", ObjectType("object")))


def call(name: str, *args: Term) -> Function:
    return Function(name, tuple(args))


def switch(left: Term, operator: str, right: Term, rows: int) -> Row:
    return Row("switch", left, operator, right, rows)


def motion(name: str, *rows: Row, symmetric: bool = False) -> MotionPredicate:
    return MotionPredicate(name, VARIABLES, symmetric, rows)


UP = Vector((Number(0), Number(0), Number(1)))
MOTIONS = {
    predicate.name: predicate
    for predicate in (
        motion("touch", switch(call("gap", X, Y), "=", Number(0), 1), symmetric=True),
        motion("stable", Row("keep", call("pose", Y, X), "", None, 6)),
        motion(
            "above",
            switch(call("bottom", X), ">=", call("top", Y), 1),
            switch(call("inside", X, Y), ">=", Number(0), 4),
        ),
        motion(
            "stand",
            switch(call("bottom", X), "=", call("top", Y), 1),
            switch(call("inside", X, Y), ">=", Number(0.03), 4),
        ),
        motion(
            "rest",
            switch(call("bottom", X), "=", call("top", Y), 1),
            switch(call("inside", X, Y), ">=", Number(0.02), 4),
            switch(call("axis", X, Letter("z")), "=", UP, 3),
        ),
        motion(
            "connectCrawlers",
            switch(
                Arith("-", (call("position", Y), call("position", X))),
                "=",
                Arith("*", (Arith("+", (call("radius", X), call("radius", Y))), call("axis", X, Letter("z")))),
                3,
            ),
            switch(Arith("+", (call("axis", X, Letter("z")), call("axis", Y, Letter("z")))), "=", Number(0), 3),
            switch(call("dot", call("axis", X, Letter("x")), call("axis", Y, Letter("y"))), "=", Number(0), 1),
        ),
    )
}
ANY_CHANGE = Rule(
    "change",
    VARIABLES,
    And(()),
    tuple(Effect(Literal(name, (X, Y), motion=True), negated=True) for name in MOTIONS),
    Number(1),
)
"""Every motion literal may end: the skeletons below are written down, not derived from rules."""


def crawler_type() -> ModuleType:
    heights = (0.0, 0.15, 0.325, 0.5, 0.675, 0.85, 1.0)
    home = (0.0, 0.3, 0.0, -0.6, 0.0, 0.3, 0.0)
    joints, links = [], []
    for i, (height, letter) in enumerate(zip(heights, "zyzyzyz", strict=True)):
        rise = height - (heights[i - 1] if i else 0.0)
        axis, limit = ((0.0, 0.0, 1.0), 3.1) if letter == "z" else ((0.0, 1.0, 0.0), 2.1)
        placement = (0.0, 0.0, rise, 0.0, 0.0, 0.0, 1.0)
        joints.append(Joint(f"j{i + 1}", "revolute", i - 1, placement, axis, -limit, limit, home[i], 2.0))
        if i:
            middle = (0.0, 0.0, rise / 2, 0.0, 0.0, 0.0, 1.0)
            links.append(Link(i - 1, middle, Shape("capsule", (0.04, rise))))
    foot = Shape("sphere", (0.05,))
    effectors = (
        Effector("A", "gripper", -1, (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0), foot),
        Effector("B", "gripper", 6, (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0), foot),
    )
    return ModuleType("crawler", tuple(joints), effectors, tuple(links))


CRAWLER = crawler_type()


def crawler(name: str, x: float, y: float, top: float, heading: float = math.pi / 2) -> Module:
    """A crawler that stands on A at (x, y) on a surface of height `top`."""
    pose = (x, y, top + 0.05, 0.0, 0.0, math.sin(heading / 2), math.cos(heading / 2))
    return Module(name, CRAWLER, pose, tuple(j.home for j in CRAWLER.joints))


def box(name: str, size: tuple[float, float, float], at: tuple[float, float, float], movable: bool = False) -> Body:
    return Body(name, "object", Shape("box", size), (*at, 0.0, 0.0, 0.0, 1.0), movable)


def make_problem(bodies: list[Body], modules: list[Module], init: set[tuple[str, ...]], task: str) -> Problem:
    types = {
        "object": None, "effector": "object", "module": None, "base": "object", "gripper": "effector",
        "crawler": "module",
    }  # fmt: skip
    objects = {b.name: b.type for b in bodies} | {m.name: m.type.name for m in modules}
    for m in modules:
        objects |= {f"{m.name}.{e.name}": e.type for e in m.type.effectors}
    return Problem(
        task, "fixture.tamp", 0, {}, types, objects, {}, {}, MOTIONS, {"change": ANY_CHANGE}, None, frozenset(),
        frozenset(init), And(()),
        World({m.name: m for m in modules}, {b.name: b for b in bodies}), Options(), (),
    )  # fmt: skip


def stairs(n: int, seed: int = 0, jitter: float = 0.03) -> list[Body]:
    """A ground plate and n stairs of the common benchmark."""
    source = random.Random(seed)
    bodies = [box("ground", (2.0, 2.0, 0.05), (-0.9, 0.0, 0.0))]
    for i in range(1, n + 1):
        x, z = 0.35 * i + source.uniform(-jitter, jitter), 0.2 * i + source.uniform(-jitter, jitter)
        bodies.append(box(f"stair[{i}]", (0.3, 0.8, 0.05), (x, 0.0, z)))
    return bodies


def target(n: int) -> Body:
    return Body("target", "object", Shape("sphere", (0.04,)), (0.35 * n, 0.0, 0.2 * n + 1.0, 0, 0, 0, 1), True)


def step_name(i: int) -> str:
    return f"stair[{i}]" if i else "ground"


def climb_alone(steps: int, seed: int = 0, stride: int = 1, grasp: bool = True) -> Skeleton:
    """One crawler: alternating steps of `stride` stairs, then it grasps the target above the top stair."""
    bodies = [*stairs(steps * stride, seed), target(steps * stride)]
    init = {("stable", "ground", "c[1].A"), ("stand", "c[1].A", "ground")}
    problem = make_problem(bodies, [crawler("c[1]", -0.2, 0.0, 0.025)], init, "climb")
    mode, phases = frozenset(init), []
    for k in range(1, steps + 1):
        stance, swing = ("c[1].A", "c[1].B") if k % 2 else ("c[1].B", "c[1].A")
        here, there = step_name((k - 1) * stride), step_name(k * stride)
        added = frozenset({("stable", there, swing), ("stand", swing, there)})
        phases.append(Phase(Action("step", (stance, swing, here, there)), mode, added))
        mode = frozenset(f for f in mode if stance not in f) | added
    if grasp:
        free = "c[1].A" if steps % 2 else "c[1].B"
        added = frozenset({("stable", free, "target"), ("touch", free, "target")})
        phases.append(Phase(Action("grasp", (free, "target")), mode, added))
        mode |= added
    return Skeleton(problem, tuple(phases), mode)


def climb_together(steps: int, seed: int = 0, stride: int = 4, n: int | None = None, grasp: bool = True) -> Skeleton:
    """Two crawlers connect and climb as one robot in steps of `stride` stairs, then it grasps the target."""
    n = n or steps * stride
    bodies = [*stairs(n, seed), target(n)]
    modules = [crawler("c[1]", -0.2, -0.175, 0.025), crawler("c[2]", -0.2, 0.175, 0.025)]
    init = {
        ("stable", "ground", "c[1].A"), ("stand", "c[1].A", "ground"),
        ("stable", "ground", "c[2].A"), ("stand", "c[2].A", "ground"),
    }  # fmt: skip
    problem = make_problem(bodies, modules, init, "climb")
    added = frozenset({("stable", "c[2].B", "c[1].B"), ("connectCrawlers", "c[2].B", "c[1].B")})
    alone = [Chain((("c[1]", "c[1].A", "c[1].B"),)), Chain((("c[2]", "c[2].B", "c[2].A"),))]
    phases = [Phase(Action("connect", tuple(alone)), frozenset(init), added)]
    mode = frozenset(f for f in init if "c[1].A" not in f) | added
    chain = [("c[2]", "c[2].A", "c[2].B"), ("c[1]", "c[1].B", "c[1].A")]
    for k in range(1, steps + 1):
        robot = Chain(tuple(chain))
        here, there = step_name(min(n, (k - 1) * stride)), step_name(min(n, k * stride))
        front, back = chain[1][1], chain[0][2]
        added = frozenset({("stable", there, robot.last), ("stand", robot.last, there), ("stable", front, back)})
        phases.append(Phase(Action("stepTogether", (robot, here, there)), mode, added))
        mode = frozenset(f for f in mode if robot.first not in f and f != ("stable", back, front)) | added
        chain = [(m, leave, enter) for m, enter, leave in reversed(chain)]
    if grasp:
        free = Chain(tuple(chain)).last
        added = frozenset({("stable", free, "target"), ("touch", free, "target")})
        phases.append(Phase(Action("grasp", (free, "target")), mode, added))
        mode |= added
    return Skeleton(problem, tuple(phases), mode)


def pick_and_place(n: int) -> Skeleton:
    """A crawler on a pedestal moves n boxes from a table to a tray."""
    bodies = [
        box("pedestal", (0.3, 0.3, 0.05), (0.0, 0.0, 0.0)),
        box("table", (0.4, 1.4, 0.04), (0.55, 0.0, 0.02)),
        box("goal_tray", (0.5, 0.3, 0.04), (0.0, -0.6, 0.02)),
    ]
    items = [f"item[{i}]" for i in range(1, n + 1)]
    for i, item in enumerate(items, start=1):
        bodies.append(box(item, (0.06, 0.06, 0.06), (0.55, 0.15 * (i - (n + 1) / 2), 0.07), movable=True))
    init = {("stable", "pedestal", "c.A"), ("stand", "c.A", "pedestal")}
    init |= {("stable", "table", item) for item in items}
    problem = make_problem(bodies, [crawler("c", 0.0, 0.0, 0.025, 0.0)], init, "pick_and_place")
    mode, phases = frozenset(init), []
    for item in items:
        held = frozenset({("stable", "c.B", item), ("touch", "c.B", item)})
        phases.append(Phase(Action("grasp", ("c.B", item)), mode, held))
        mode = frozenset(f for f in mode if f != ("stable", "table", item)) | held
        laid = frozenset({
            ("stable", "goal_tray", item), ("rest", item, "goal_tray"), ("above", item, "goal_tray"),
        })  # fmt: skip
        phases.append(Phase(Action("place", ("c.B", item, "goal_tray")), mode, laid))
        mode = (mode - held) | laid
    return Skeleton(problem, tuple(phases), mode)
