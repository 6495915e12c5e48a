"""Exports tell the masses that the texts state, whether the plan asks for physics or not."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree as Xml

import mujoco
import numpy as np
import pytest

from tamplang.runtime.export import write

from .loaded import ALL_MASS, MOMENT, OUT, reaching


@pytest.mark.parametrize("physics", ["statics", "none"])
def test_masses_and_efforts_are_the_stated_ones(physics: str, tmp_path: Path) -> None:
    plan = reaching(physics=physics, hoist="torque 7 N m mass 250 g")
    write(plan, "urdf", tmp_path / "a.urdf")
    root = Xml.parse(tmp_path / "a.urdf").getroot()
    assert sum(float(m.get("value")) for m in root.iter("mass")) == pytest.approx(ALL_MASS + 0.25)
    limits = {j.get("name"): j.find("limit") for j in root.iter("joint")}
    efforts = {name: float(limit.get("effort")) for name, limit in limits.items() if limit is not None}
    assert efforts["a.lift"] == 7.0 and efforts["a.turn"] == 1000.0
    write(plan, "mjcf", tmp_path / "a.xml")
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "a.xml"))
    # A frame that weighs nothing gets a gram, as the engine has none without a mass.
    assert model.body("a").subtreemass[0] == pytest.approx(ALL_MASS + 0.25, abs=2e-3)
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    data.qacc[:] = 0.0
    mujoco.mj_inverse(model, data)
    lift = data.qfrc_inverse[int(model.joint("a.lift").dofadr[0])]
    assert abs(lift) == pytest.approx(MOMENT - 9.81 * OUT, rel=1e-6) and np.isfinite(data.qfrc_inverse).all()
