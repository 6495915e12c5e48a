"""Whole plans of an arm that bears a load, and of one whose joints have no drives."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from tamplang.runtime.plan import Plan

from .motions import Maker

TEXT = """
import std.logic
import std.motion

## Is fastened, or set down, as each plan says.
type claw < effector

## Bears 1 kg on an arm that reaches out along x.
module arm {
    effector foot: claw sphere(5 cm) normal (0, 0, -1) mass 3 kg HOLDS
    link 20 cm
    joint turn: revolute(z) in -1 rad .. 1 rad TURN
    joint lift: revolute(y) in -1 rad .. 1 rad LIFT
    link (10 cm, 0, 0)
    joint slide: prismatic(x) in 0 m .. 20 cm SLIDE
    effector tip: gripper sphere(5 cm) mass 1 kg
}

motion [bear X: effector, Y: object] borne MANNER { at switch bottom(X) = top(Y) }
motion [asks X: effector] { ROW }
placement (A: claw) on (Y: object) { [stable Y A], [bear A Y] }
predicate (done X: effector)
rule wave(X: effector) { post (done X), [asks X] }

task reach() {
    base slab: box(20 cm, 20 cm, 5 cm) at (0, 0, -2.5 cm)
    arm a: foot on slab
    goal (done a.tip)
    options { physics = PHYSICS, safety = 1 }
}
"""
OUT = 0.1
"""Metres by which the arm slides out: as far as the load was from the axis before."""
MOMENT = 9.81 * (0.1 + OUT)
"""N m of the load about the axis of the arm, then."""
ALL_MASS = 4.0
"""Kilograms, of which the load is one: the middle of all of it is as far out as the foot is wide."""


def reaching(
    lift: float = 0.0, slide: float = OUT, turn: str = "", hoist: str = "", rail: str = "",
    manner: str = "pad", holds: str = "", physics: str = "statics", row: str = "during top(X) >= -1 m",
) -> Plan:  # fmt: skip
    """The arm slides out; what is said of its joints and its foot is stated in the text."""
    given = {
        "TURN": turn, "LIFT": hoist, "SLIDE": rail, "MANNER": manner, "HOLDS": holds, "PHYSICS": physics, "ROW": row,
    }  # fmt: skip
    text = TEXT
    for word, stated in given.items():
        text = text.replace(word, stated)
    maker = Maker(text, "reach")
    maker.phase("wave", ("a.tip",), [np.array([0.0, lift, slide])])
    return maker.plan()


def strength(ratio: float) -> str:
    """What the moment of the load is that share of."""
    return f"{MOMENT / ratio:.12f} N m"


LOADED: dict[str, Callable[[float], Plan]] = {
    "torque_ratio": lambda x: reaching(hoist=f"torque {strength(x)}"),
    "bearing_ratio": lambda x: reaching(turn=f"bearing {strength(x)}"),
    "dock_ratio": lambda x: reaching(manner="dock", holds=f"holds dock(force 1 kN, moment {strength(x)})"),
    "foot_ratio": lambda x: reaching(holds=f"holds pad(force 1 kN, moment {strength(x)})"),
    "tip_m": lambda x: reaching(slide=OUT + ALL_MASS * x, manner="rest", holds="holds rest(friction 0.8)"),
    "load_share": lambda x: reaching(row=f"at switch abs(torque(X.lift)) <= {MOMENT / (1.0 + x):.12f} N m"),
    "undriven_m": lambda x: reaching(slide=x, rail="passive", physics="none"),
    "undriven_rad": lambda x: reaching(lift=x, slide=0.0, hoist="passive", physics="none"),
}
"""Plans whose figure of a kind is the amount that is given."""
