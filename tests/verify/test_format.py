"""The page on the plan file tells the truth: its example, its code, and all its fields."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest

from tamplang.runtime import plan as record
from tamplang.runtime.plan import Plan
from tamplang.runtime.verify.kinematics import Kinematics, motion_of
from tamplang.runtime.verify.limits import LIMITS, RATES

PAGE = (Path(__file__).parents[2] / "docs" / "plan-format.md").read_text(encoding="utf-8")


def effector_pose() -> Callable[..., list[float]]:
    """The function that the page defines."""
    code = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)[0].split("\nplan = json")[0]
    names: dict[str, Any] = {}
    exec(compile(code, "plan-format.md", "exec"), names)
    found: Callable[..., list[float]] = names["effector_pose"]
    return found


def test_worked_example() -> None:
    example = json.loads(re.findall(r"```json\n(.*?)```", PAGE, re.DOTALL)[0])
    tip = effector_pose()(example, "c", "B", 0)
    assert tip[:3] == pytest.approx([1.0, 0.3, 0.275])
    kinematics = Kinematics(msgspec.convert(example["modules"][0], record.ModuleRecord))
    joints = kinematics.joint_frames(np.array(example["tracks"][0]["poses"]), np.array([[np.pi / 2]]))
    for name, normal in (("A", [0, 0, -1]), ("B", [0, 1, 0])):
        assert kinematics.effector(name, joints).rotation[0, :, 2] == pytest.approx(normal)


def test_code_of_the_page_agrees_with_pinocchio(hop: Plan) -> None:
    data = msgspec.to_builtins(hop)
    frames = motion_of(hop, {m.name: Kinematics(m) for m in hop.modules}).frames
    pose_of = effector_pose()
    for sample in (0, 57, 200, -1):
        for name in ("A", "B"):
            assert pose_of(data, "c", name, sample)[:3] == pytest.approx(frames[f"c.{name}"].position[sample])


def test_every_field_and_measure_is_described() -> None:
    structs = [s for s in vars(record).values() if isinstance(s, type) and issubclass(s, msgspec.Struct)]
    fields = {f for s in structs if s not in (record.Record, record.SearchNode) for f in s.__struct_encode_fields__}
    words = set(re.findall(r"\w+", PAGE))
    assert fields - words == set()
    assert {*LIMITS, *RATES} - {"time_s"} <= words


def test_the_documented_limits_are_those_of_the_checker() -> None:
    found = set()
    for kinds, limits in re.findall(r"^\| (`[^|]*) \|[^|]*\| ([^|]*[0-9][^|]*)\|$", PAGE, re.MULTILINE):
        named = [kind for kind in re.findall(r"`(\w+)`", kinds) if kind in LIMITS]
        told = {float(n) * (1e-3 if u else 1.0) for n, u in re.findall(r"([0-9][0-9.e-]*)( mm| mrad)?", limits)}
        if named:
            found |= set(named)
            assert told == {LIMITS[kind] for kind in named}, kinds
    assert found == LIMITS.keys() - {"time_s"}
