"""Meshes that models of SDF, rai and CoBRA name are read as those of URDFs: hollow ones by their convex parts, others
by their hull, with where they lie and how large they are."""

from __future__ import annotations

import math
import re
import struct
from collections.abc import Sequence
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from .conftest import Command, problems, refused

BRICK = [(0.0, 0.0), (0.2, 0.0), (0.2, 0.1), (0.0, 0.1)]
ELL = [(0.0, 0.0), (0.3, 0.0), (0.3, 0.05), (0.05, 0.05), (0.05, 0.3), (0.0, 0.3)]
MATRIX = "[[0, -1, 0, 0.5], [1, 0, 0, 0.2], [0, 0, 1, 0.1], [0, 0, 0, 1]]"
MODULE = (
    '{"modules": [{"ID": "a", "bodies": [{"ID": "b", "collision": [{"type": "mesh", "parameters": {"file": "%s", '
    '"scale": 2.0}, "pose": %s}], "connectors": [{"ID": "c", "gender": "m"}]}], "joints": []}]}'
)
OBSTACLE = (
    '{"obstacles": [{"ID": 1, "name": "wall", "collision": [{"type": "mesh", "parameters": {"file": "%s", "scale": '
    '[2, 2, 2]}, "pose": %s}]}]}'
)
SDF = (
    '<sdf version="1.9"><model name="m"><static>%s</static><pose>0.5 0.2 0.1 0 0 1.5707963267948966</pose>'
    '<link name="l"><collision name="c"><geometry><mesh><uri>%s</uri><scale>2 2 2</scale></mesh></geometry>'
    "</collision></link></model></sdf>"
)
RAI = "w: {}\nm (w): { %s Q: [.5, .2, .1, .707106781186547, 0, 0, .707106781186547], mesh: <%s>, meshscale: 2 }\n"


def write_prism(path: str, outline: Sequence[tuple[float, float]], high: float = 0.05) -> None:
    """A body over an outline that is seen whole from its first corner, as binary STL."""
    n = len(outline)
    points = [(x, y, z) for z in (0.0, high) for x, y in outline]
    faces = [(i, (i + 1) % n, n + (i + 1) % n) for i in range(n)] + [(i, n + (i + 1) % n, n + i) for i in range(n)]
    faces += [(0, k + 1, k) for k in range(1, n - 1)] + [(n, n + k, n + k + 1) for k in range(1, n - 1)]
    packed = b"".join(struct.pack("<12fH", 0, 0, 0, *(v for i in face for v in points[i]), 0) for face in faces)
    Path(path).write_bytes(b"\0" * 80 + struct.pack("<I", len(faces)) + packed)


def where(outline: Sequence[tuple[float, float]], high: float = 0.05) -> np.ndarray:
    """The corners of the prism, twice as large, turned by a right angle, at (0.5, 0.2, 0.1)."""
    return np.array([(0.5 - 2 * y, 0.2 + 2 * x, 0.1 + 2 * z) for z in (0.0, high) for x, y in outline])


def bodies(text: str, kind: str) -> list[np.ndarray]:
    """The corners in the world of the hulls that the bodies of a program are made of."""
    found = []
    for line in re.findall(rf"^ *{kind} \w+: (.*)$", text, re.M):
        numbers = [float(v) for v in re.findall(r"(-?[\d.e-]+) m\b", line)]
        if "union(" not in line:
            corners = np.array(numbers).reshape(-1, 3)
            found.append(corners[:-1] + corners[-1])
            continue
        parts = re.findall(r"hull\((.*?)\) at (\([^)]*\))", line)
        of = [[float(v) for v in re.findall(r"(-?[\d.e-]+) m", p)] for part in parts for p in part]
        placed = [np.array(a).reshape(-1, 3) + b for a, b in zip(of[::2], of[1::2], strict=True)]
        whole = np.concatenate(placed)
        middle = (whole.min(axis=0) + whole.max(axis=0)) / 2
        found += [part - middle + numbers[-3:] for part in placed]
    return found


def parts_of_urdf(file: str) -> list[np.ndarray]:
    """The corners of the convex shapes of a URDF whose links all lie at its root, in it."""
    found = []
    for collision in ElementTree.parse(file).iter("collision"):
        origin, convex = collision.find("origin"), collision.find("geometry/convex")
        assert origin is not None and convex is not None
        at = np.array([float(v) for v in origin.get("xyz", "").split()])
        x, y, z, w = (float(v) for v in origin.get("quat_xyzw", "0 0 0 1").split())
        turn = np.array([
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ])  # fmt: skip
        found.append(np.array([float(v) for v in convex.get("points", "").split()]).reshape(-1, 3) @ turn.T + at)
    return found


FILES = {
    "still.sdf": (SDF.replace("%s", "true", 1), "base"), "loose.sdf": (SDF.replace("%s", "false", 1), "object"),
    "still.g": (RAI.replace("%s", "", 1), "base"), "loose.g": (RAI.replace("%s", "joint: rigid,", 1), "object"),
    "wall.json": (OBSTACLE % ("%s", MATRIX), "base"), "part.json": (MODULE % ("%s", MATRIX), "module"),
}  # fmt: skip


@pytest.mark.parametrize("name", FILES)
def test_a_mesh_lies_where_its_file_puts_it(command: Command, name: str) -> None:
    text, kind = FILES[name]
    write_prism("brick.stl", BRICK)
    write_prism("ell.stl", ELL)
    for mesh, outline, many in (("brick.stl", BRICK, 1), ("ell.stl", ELL, 2)):
        Path(name).write_text(text % mesh)
        answer = command("import", name, "-o", "o.tamp")
        assert answer.status == 0 and "[W0006]" in answer.told and f"{name}:" in answer.told, answer.told
        assert ("2 convex parts" in answer.told) == (many == 2), answer.told
        assert not [code for code in problems(command, "o.tamp") if code[0] == "E"]
        found = parts_of_urdf("o_a.urdf") if kind == "module" else bodies(Path("o.tamp").read_text(), kind)
        assert len(found) == (1 if many == 1 else 2 if kind in ("object", "module", "base") else 1)
        corners, wanted = np.concatenate(found), where(outline)
        off = np.linalg.norm(corners[:, None] - wanted[None], axis=2)
        assert off.min(axis=0).max() < 1e-6, "a corner of the mesh is none of the parts"
        area = {4: 0.02, 6: 0.3 * 0.05 + 0.25 * 0.05}[len(outline)]
        assert sum(ConvexHull(part).volume for part in found) == pytest.approx(8 * area * 0.05, rel=1e-5)


@pytest.mark.parametrize("name", FILES)
@pytest.mark.parametrize("fault", ["away", "broken", "of another kind", "a folder", "flat"])
def test_a_mesh_that_is_none_is_told_at_its_place(command: Command, name: str, fault: str) -> None:
    text, kind = FILES[name]
    Path("folder.stl").mkdir()
    Path("broken.stl").write_bytes(b"\0" * 80 + struct.pack("<I", 90) + b"no mesh")
    Path("scene.h5").write_bytes(b"\x89HDF")
    write_prism("flat.stl", BRICK, 0.0)
    mesh = {"away": "away.stl", "broken": "broken.stl", "of another kind": "scene.h5", "a folder": "folder.stl"}
    Path(name).write_text(text % mesh.get(fault, "flat.stl"))
    if fault != "flat":
        told = refused(command, {"E0515"}, name)
        assert f"{name}:" in told
    elif kind == "module":
        assert "[W0019]" in command("import", name, "-o", "o.tamp").told
    else:
        refused(command, {"E0020"}, name)


def test_packages_are_folders_above(command: Command) -> None:
    deep = Path("models/robot/sdf")
    deep.mkdir(parents=True)
    write_prism("brick.stl", BRICK)
    Path("brick.stl").rename("models/robot/brick.stl")
    Path(deep / "m.sdf").write_text(SDF % ("true", "model://robot/brick.stl"))
    answer = command("import", str(deep / "m.sdf"), "-o", "o.tamp")
    assert answer.status == 0 and "no folder of the name" not in answer.told
    Path(deep / "m.sdf").write_text(SDF % ("true", "model://other/brick.stl"))
    assert "no folder of the name" in command("import", str(deep / "m.sdf"), "-o", "o.tamp").told
    Path(deep / "m.sdf").write_text(SDF % ("true", "package://big/tree/of/models/robot/brick.stl"))
    told = command("import", str(deep / "m.sdf"), "-o", "o.tamp").told
    assert "no folder of the name of its package holds it, so models/robot/brick.stl is taken" in told


def test_meshes_of_rai_that_nothing_hits_are_left_out(command: Command) -> None:
    shown = "k (w): { mesh: <not_there.h5> }\nt (w): { shape: ssBox, size: [1, 1, .1, .01], contact: 1 }\n"
    Path("s.g").write_text("w: {}\n" + shown)
    answer = command("import", "s.g", "-o", "o.tamp")
    assert answer.status == 0 and "the mesh of `k` is left out" in answer.told and "s.g:2:" in answer.told


def test_what_hangs_together_is_one_thing(command: Command) -> None:
    ball = '<collision name="d"><pose>0 0 0.3 0 0 0</pose><geometry><sphere><radius>0.05</radius></sphere></geometry>'
    box = '<collision name="c"><pose>0 0 0 0 0 0.3</pose><geometry><box><size>.2 .1 .1</size></box></geometry>'
    mass = "<inertial><mass>0.5</mass></inertial>"
    link = f'<link name="l">{mass}{box}</collision>{ball}</collision></link>'
    Path("m.sdf").write_text(f'<sdf version="1.9"><model name="club"><pose>1 2 .05 0 0 0</pose>{link}</model></sdf>')
    Path("m.xml").write_text(
        '<mujoco><worldbody><body name="club" pos="1 2 .05"><freejoint/><geom type="box" size=".1 .05 .05" mass=".25" '
        f'euler="0 0 {math.degrees(0.3)}"/><body pos="0 0 .3"><geom size=".05" mass=".25"/></body></body></worldbody>'
        "</mujoco>"
    )
    Path("m.g").write_text(
        'w: {}\nclub (w): { joint: rigid, X: [1, 2, .05], mass: .5 }\nd (club): { Q: "r(.3 0 0 1)", shape: box, '
        "size: [.2, .1, .1] }\nf (club): { Q: [0, 0, .3], shape: sphere, size: [.05] }\n"
    )
    for name in ("m.sdf", "m.xml", "m.g"):
        assert command("import", name, "-o", "o.tamp").status == 0
        assert not problems(command, "o.tamp"), name
        text = Path("o.tamp").read_text()
        assert text.count("object") == 1 and "mass 0.5 kg" in text and "(grippable club)" in text, text
        assert "at (1 m, 2 m, 0.3 m)) at (1 m, 2 m, 0.175 m)" in text or "0.35 m)) at (1 m, 2 m, 0.2 m)" in text, text
