"""Models that the bench makes: random trees of links in URDF, MJCF, SDF, rai and as modules of a catalogue."""

from __future__ import annotations

import json
import math
from pathlib import Path
from random import Random

COUNT, LINKS = 12, 8
KINDS = ("revolute", "prismatic", "continuous", "fixed")


def numbers(random: Random, most: float = 0.5) -> str:
    """Three numbers."""
    return " ".join(f"{random.uniform(-most, most):.6f}" for _ in range(3))


def write(folder: Path) -> None:
    """All of them, into a new folder."""
    folder.mkdir()
    for number in range(COUNT):
        for ending, make in ((".urdf", urdf), (".xml", mjcf), (".sdf", sdf), (".g", rai), (".json", modules)):
            (folder / f"made{number}{ending}").write_text(make(Random(number)))


def urdf(random: Random) -> str:
    """A tree of links with spheres."""
    ball = '<collision><geometry><sphere radius="0.02"/></geometry></collision>'
    lines = [f'<robot name="r"><link name="l0">{ball}</link>']
    for k in range(1, LINKS):
        lines.append(f'<link name="l{k}">{ball}</link><joint name="j{k}" type="{random.choice(KINDS)}">')
        lines.append(f'<parent link="l{random.randrange(k)}"/><child link="l{k}"/><axis xyz="{numbers(random)}"/>')
        lines.append(f'<origin xyz="{numbers(random)}" rpy="{numbers(random, math.pi)}"/>')
        lines.append('<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>')
    return "\n".join([*lines, "</robot>"])


def mjcf(random: Random) -> str:
    """A chain with joints at points of their own."""
    text = ""
    for k in reversed(range(LINKS)):
        kind = random.choice(("hinge", "slide"))
        joint = f'<joint name="j{k}" type="{kind}" axis="{numbers(random)}" pos="{numbers(random)}" range="-1 1"/>'
        place = f'pos="{numbers(random)}" euler="{numbers(random, 90)}"'
        text = f'<body name="b{k}" {place}>\n{joint}\n<geom size="0.02"/>\n{text}</body>\n'
    return f"<mujoco><worldbody>\n<body name='base'><geom size='0.1'/>\n{text}</body></worldbody></mujoco>"


def sdf(random: Random) -> str:
    """A chain with poses relative to the link before."""
    lines = ["<sdf version='1.9'><model name='m'><link name='l0'/>"]
    for k in range(1, LINKS):
        pose = f"{numbers(random)} {numbers(random, 3.0)}"
        lines.append(f"<link name='l{k}'><pose relative_to='l{k - 1}'>{pose}</pose></link>")
        kind = random.choice(KINDS[:2])
        lines.append(f"<joint name='j{k}' type='{kind}'><parent>l{k - 1}</parent><child>l{k}</child>")
        limit = "<limit><lower>-1</lower><upper>1</upper></limit>"
        lines.append(f"<axis><xyz>{numbers(random)}</xyz>{limit}</axis></joint>")
    return "\n".join([*lines, "</model></sdf>"])


def rai(random: Random) -> str:
    """A chain on a table."""
    lines = ["world: {}", "table (world): { shape: ssBox, size: [2, 2, .1, .02] }"]
    above = "table"
    for k in range(LINKS):
        kind = random.choice(("hingeX", "hingeY", "hingeZ", "transX", "transY", "transZ"))
        x, y, z = numbers(random).split()
        pre = f'"t({x} {y} {z}) d(30 1 0 0)"'
        lines.append(f"j{k} ({above}): {{ joint: {kind}, pre: {pre}, limits: [-1, 1], shape: sphere, size: [.02] }}")
        above = f"j{k}"
    return "\n".join(lines)


def modules(random: Random) -> str:
    """Three modules of one joint and two connectors each."""
    found = []
    for k in range(3):
        turn = random.uniform(-3, 3)
        c, s = math.cos(turn), math.sin(turn)
        pose = [[c, 0, s, 0], [0, 1, 0, 0], [-s, 0, c, random.uniform(0.1, 0.3)], [0, 0, 0, 1]]
        ends = [{"ID": g, "gender": g, "size": [80], "type": "flange", "pose": pose} for g in "mf"]
        joint = {
            "ID": "j", "parent": 0, "child": 1, "type": "revolute", "poseParent": pose, "poseChild": pose,
            "limits": {"positionLower": -1, "positionUpper": 1, "velocity": math.inf},
        }  # fmt: skip
        bodies = [{"ID": b, "connectors": [ends[b]], "collision": []} for b in (0, 1)]
        found.append({"header": {"ID": f"m{k}"}, "bodies": bodies, "joints": [joint]})
    return json.dumps(found, indent=1)
