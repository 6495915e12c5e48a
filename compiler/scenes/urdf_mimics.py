"""Joints of a URDF that follow others by `mimic`."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from xml.etree import ElementTree

from .. import ir
from ..poses import about, compose, make
from .couplings import BadCoupling, StatedCoupling, couple
from .joints import STRAIGHT
from .urdf_joints import SCALAR
from .urdf_reading import Reading, UrdfJoint


def coupled(
    reading: Reading, joints: Sequence[ir.Joint], declared: Sequence[UrdfJoint]
) -> tuple[ir.Joint, ...] | None:
    """The joints with those that `mimic` others; where 0 is outside what followers leave a joint, it starts in the
    middle of that. None after a fault."""
    stated, moving, known = dict[str, StatedCoupling](), {j.name for j in joints}, {j.name for j in declared}
    elements = {j.name: j.element.find("mimic") for j in declared if j.name in moving}
    for name, mimic in elements.items():
        if mimic is None:
            continue
        leader, factor = mimic.get("joint", ""), reading.number(mimic, "multiplier", "1")
        offset = reading.number(mimic, "offset", "0")
        if leader not in moving:
            what = "cannot be followed" if leader in known else "is not there"
            reading.warn(mimic, f"joint `{name}` follows `{leader}`, which {what}: it moves by itself")
        elif factor is not None and offset is not None:
            stated[name] = StatedCoupling(leader, factor, offset)
    if not reading.sound:
        return None
    try:
        made = _loosely_coupled(reading, list(joints), stated, elements)
        homes = [j if j.lower <= j.home <= j.upper else replace(j, home=(j.lower + j.upper) / 2) for j in made]
        return couple([h if j.follows is None else j for h, j in zip(homes, made, strict=True)], {})
    except BadCoupling as mistake:
        blamed = elements.get(mistake.joint)
        where = blamed if blamed is not None else declared[0].element
        reading.fault(where, str(mistake), mistake.help, "E0521")
        return None


def _loosely_coupled(
    reading: Reading, joints: list[ir.Joint], stated: Mapping[str, StatedCoupling],
    elements: Mapping[str, ElementTree.Element | None],
) -> tuple[ir.Joint, ...]:  # fmt: skip
    """`couple`, but that limits of followers which leave their leaders nothing do not count, as in other readers.
    Raises BadCoupling."""
    names = [j.name for j in joints]
    while True:
        try:
            made = couple(joints, stated)
        except BadCoupling as mistake:
            at, mimic = names.index(mistake.joint), elements.get(mistake.joint)
            if not mistake.narrow or mimic is None or math.isinf(joints[at].upper):
                raise
            reading.warn(mimic, f"{mistake}: those of `{mistake.joint}` do not count")
            joints[at] = replace(joints[at], lower=-math.inf, upper=math.inf)
        else:
            return tuple(_within_leader(joint, made) for joint in made)


def _within_leader(joint: ir.Joint, joints: Sequence[ir.Joint]) -> ir.Joint:
    """A follower whose limits do not count goes as far as its leader takes it."""
    if joint.follows is None or not math.isinf(joint.upper):
        return joint
    leader = joints[joint.follows.leader]
    ends = sorted(joint.follows.factor * end + joint.follows.offset for end in (leader.lower, leader.upper))
    return replace(joint, lower=ends[0], upper=ends[1])


def settled(reading: Reading, declared: Sequence[UrdfJoint], limited: Collection[str]) -> list[UrdfJoint]:
    """The joints, of which those that `mimic` one that stands still are fixed where that puts them. The module itself
    says what `limited` joints may do."""
    values = _stills({joint.name: joint for joint in declared}, limited)
    found = []
    for joint in declared:
        value = None if joint.kind not in SCALAR else values[joint.name]
        if value is None or joint.element.find("mimic") is None:
            found.append(joint)
            continue
        reading.warn(joint.element, f"joint `{joint.name}` follows what stands still, and is fixed at {value:g}")
        x, y, z = (value * a for a in joint.axis)
        turns = SCALAR[joint.kind] == ir.JointKind.REVOLUTE
        motion = make((0.0, 0.0, 0.0), about(joint.axis, value)) if turns else make((x, y, z), STRAIGHT)
        found.append(replace(joint, kind="fixed", origin=compose(joint.origin, motion)))
    return found


def _stills(known: Mapping[str, UrdfJoint], limited: Collection[str]) -> dict[str, float | None]:
    """The value at which each joint stands still; None where it moves."""
    values: dict[str, float | None] = {}
    for name in known:
        way: list[str] = []
        while name in known and name not in values:
            values[name] = None  # what follows itself moves
            way.append(name)
            leader = _followed(known[name])
            name = "" if leader is None else leader[0]
        for follower in reversed(way):
            values[follower] = _still(known[follower], values, limited)
    return values


def _followed(joint: UrdfJoint) -> tuple[str, float, float] | None:
    """The leader of a joint that follows one, with factor and offset; a factor of 0 follows nothing."""
    mimic = None if joint.kind == "fixed" else joint.element.find("mimic")
    if mimic is None:
        return None
    factor, offset = _number(mimic, "multiplier", "1"), _number(mimic, "offset", "0")
    return None if factor is None or offset is None else (mimic.get("joint", "") if factor else "", factor, offset)


def _still(joint: UrdfJoint, values: Mapping[str, float | None], limited: Collection[str]) -> float | None:
    """The value at which a joint stands still, where those of leaders are known; None where it moves."""
    mimic, limit, followed = joint.element.find("mimic"), joint.element.find("limit"), _followed(joint)
    if joint.kind == "fixed":
        return 0.0
    if followed is not None:
        leader, factor, offset = followed
        value = values.get(leader) if factor else 0.0
        return None if value is None else factor * value + offset
    told = limit is not None and joint.kind != "continuous" and joint.name not in limited
    if mimic is not None or limit is None or not told or (limit.get("lower") is None and limit.get("upper") is None):
        return None
    lower, upper = _number(limit, "lower", "0"), _number(limit, "upper", "0")
    return lower if lower == upper else None


def _number(element: ElementTree.Element, name: str, default: str) -> float | None:
    """A number of an attribute; None where it is none, which is told where it is used."""
    try:
        value = float(element.get(name, default))
    except ValueError:
        return None
    return value if math.isfinite(value) else None
