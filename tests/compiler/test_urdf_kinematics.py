"""The kinematics of URDFs, against those of Pinocchio, on random robots in random configurations."""

from __future__ import annotations

import math
from pathlib import Path
from random import Random

import numpy as np
import pinocchio
import pytest

from tamplang.compiler.ir import IDENTITY
from tamplang.compiler.pipeline import compile_problem
from tamplang.compiler.poses import compose, joint_frames

BALL = '<collision><geometry><sphere radius="0.02"/></geometry></collision>'


def numbers(random: Random, most: float = 1.0) -> str:
    return " ".join(f"{random.uniform(-most, most):.6f}" for _ in range(3))


def robot(random: Random, links: int) -> str:
    """A random tree of links with joints of all kinds that are told apart by their values alone."""
    lines = [f'<robot name="r"><link name="l0">{BALL}</link>']
    for k in range(1, links):
        kind = random.choice(["revolute", "prismatic", "continuous", "fixed", "floating"])
        lines.append(f'<link name="l{k}">{BALL}</link><joint name="{random.randrange(10**6)}j{k}" type="{kind}">')
        lines.append(f'<parent link="l{random.randrange(k)}"/><child link="l{k}"/>')
        lines.append(f'<origin xyz="{numbers(random)}" rpy="{numbers(random, math.pi)}"/>')
        lines.append(f'<axis xyz="{numbers(random)}"/>' if kind != "floating" else "")
        lines.append('<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>')
    return "".join([*lines, "</robot>"])


@pytest.mark.parametrize("seed", range(8))
def test_every_link_is_where_pinocchio_has_it(tmp_path: Path, seed: int) -> None:
    random = Random(seed)
    text = robot(random, 9)
    (tmp_path / "r.urdf").write_text(text)
    effectors = "".join(f'effector e{k}: "l{k}" sphere(1 mm)\n' for k in range(9))
    (tmp_path / "r.tamp").write_text(f"""predicate (lit)
        rule light() {{ pre not (lit) post (lit) }}
        module r from urdf "r.urdf" {{ {effectors} }}
        task t() {{ r a: at (0, 0, 0) goal (lit) }}""")
    module = compile_problem(tmp_path / "r.tamp", None, {}, 0)[0].world.modules["a"].type
    model = pinocchio.buildModelFromXML(text)
    data = model.createData()
    for _ in range(5):
        values = {j.name: random.uniform(-1, 1) for j in module.joints}
        pinocchio.framesForwardKinematics(model, data, configuration(model, values))
        frames = joint_frames(module, IDENTITY, [values[j.name] for j in module.joints])
        for effector in module.effectors:
            ours = compose(frames[effector.joint], effector.placement)
            placed = data.oMf[model.getFrameId(f"l{effector.name[1:]}")]
            theirs = pinocchio.SE3ToXYZQUAT(placed)
            sign = math.copysign(1.0, float(np.dot(theirs[3:], ours[3:])))
            assert ours == pytest.approx([*theirs[:3], *(sign * theirs[3:])], abs=1e-9)
    assert [j.name for j in module.joints if "." not in j.name] == [
        n for n in model.names[1:] if f"{n}.x" not in values
    ]


def configuration(model: pinocchio.Model, values: dict[str, float]) -> np.ndarray:
    """Pinocchio's configuration for values of our joints."""
    found = pinocchio.neutral(model)
    for joint, name in zip(model.joints[1:], model.names[1:], strict=True):
        if joint.nq == 7:
            x, y, z, yaw, pitch, roll = (values[f"{name}.{n}"] for n in ("x", "y", "z", "yaw", "pitch", "roll"))
            turn = pinocchio.Quaternion(pinocchio.rpy.rpyToMatrix(roll, pitch, yaw))
            found[joint.idx_q : joint.idx_q + 7] = [x, y, z, *turn.coeffs()]
        elif joint.nq == 2:
            found[joint.idx_q : joint.idx_q + 2] = math.cos(values[name]), math.sin(values[name])
        else:
            found[joint.idx_q] = values[name]
    return found


FOLLOWERS = f"""<robot name="r"><link name="l0">{BALL}</link><link name="l1">{BALL}</link><link name="l2">{BALL}</link>
<link name="l3">{BALL}</link><link name="l4">{BALL}</link><link name="l5">{BALL}</link>
<xacro:sensor on="l1"/>
<joint name="turn" type="revolute"><parent link="l0"/><child link="l1"/><origin xyz="0.1 0 0.2"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
<joint name="rack" type="prismatic"><parent link="l1"/><child link="l2"/><origin xyz="0 0.1 0"/><axis xyz="1 0 0"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/><mimic joint="turn" multiplier="0.05" offset="0.01"/></joint>
<joint name="short" type="revolute"><parent link="l2"/><child link="l3"/><axis xyz="0 1 0"/>
<limit lower="2" upper="3" effort="1" velocity="1"/><mimic joint="turn"/></joint>
<joint name="weld" type="fixed"><parent link="l3"/><child link="l4"/><origin xyz="0 0 0.1"/></joint>
<joint name="held" type="revolute"><parent link="l4"/><child link="l5"/><origin xyz="0 0.1 0"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/><mimic joint="weld" offset="0.3"/></joint>
</robot>"""


def test_followers_of_all_kinds_are_where_their_leaders_take_them(tmp_path: Path) -> None:
    """A rack that a turning joint slides, limits that leave a leader nothing, a leader that stands still, and what
    xacro did not fill in; Pinocchio takes the values of the followers that they have by the format."""
    (tmp_path / "r.urdf").write_text(FOLLOWERS)
    (tmp_path / "r.tamp").write_text("""predicate (lit)
        rule light() { pre not (lit) post (lit) }
        module r from urdf "r.urdf" { effector e: "l5" sphere(1 mm) }
        task t() { r a: at (0, 0, 0) goal (lit) }""")
    problem, told = compile_problem(tmp_path / "r.tamp", None, {}, 0)
    said = " ".join(d.message for d in told)
    for what in ("xacro:sensor", "those of `short` do not count", "is fixed at 0.3"):
        assert what in said
    module = problem.world.modules["a"].type
    assert [j.name for j in module.joints] == ["turn", "rack", "short"]
    assert (module.joints[0].lower, module.joints[0].upper) == (-1.0, 1.0)
    model = pinocchio.buildModelFromXML(FOLLOWERS)
    data, effector = model.createData(), module.effectors[0]
    for turn in (-1.0, 0.4, 1.0):
        values = {"turn": turn, "rack": 0.05 * turn + 0.01, "short": turn, "held": 0.3}
        pinocchio.framesForwardKinematics(model, data, np.array([values[n] for n in model.names[1:]]))
        frames = joint_frames(module, IDENTITY, [values[j.name] for j in module.joints])
        theirs = pinocchio.SE3ToXYZQUAT(data.oMf[model.getFrameId("l5")])
        ours = compose(frames[effector.joint], effector.placement)
        sign = math.copysign(1.0, float(np.dot(theirs[3:], ours[3:])))
        assert ours == pytest.approx([*theirs[:3], *(sign * theirs[3:])], abs=1e-9)
