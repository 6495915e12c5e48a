"""Bodies that are not convex: meshes cut into parts, parts in text, what is told of bad meshes, and plans that reach
into hollows."""

from __future__ import annotations

import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from msgspec import structs

from tamplang import cli
from tamplang.compiler.convex_cuts import cut, hull_volume
from tamplang.compiler.ir import Shape, ShapeKind
from tamplang.compiler.mesh_surfaces import surface_of
from tamplang.compiler.physics.masses import shape_mass
from tamplang.compiler.physics.moments import shape_moments
from tamplang.compiler.pipeline import compile_problem
from tamplang.compiler.unions import union
from tamplang.runtime.export.mujoco import scene
from tamplang.runtime.plan_files import read_plan
from tamplang.runtime.verify import verify
from tamplang.runtime.verify.inertia import mass_of, moments

CRATE = [(15, 12, 0), (15, 12, 12), (14, 11, 12), (14, 11, 1)]
"""Half sides in x and y, and heights, of the outline of a crate, centimetres."""
ROOM = """
import std.crawler
import std.rules
scene room() {
    base foot: box(30 cm, 30 cm, 5 cm) at (0, 0, 0)
    object table: box(60 cm, 60 cm, 20 cm) at (70 cm, 0, 0)
    crawler c: A on foot
}
"""
PARTS = """union(
    box(30 cm, 24 cm, 1 cm) at (0, 0, 0),
    box(1 cm, 24 cm, 12 cm) at (14.5 cm, 0, 5.5 cm), box(1 cm, 24 cm, 12 cm) at (-14.5 cm, 0, 5.5 cm),
    box(30 cm, 1 cm, 12 cm) at (0, 11.5 cm, 5.5 cm), box(30 cm, 1 cm, 12 cm) at (0, -11.5 cm, 5.5 cm))"""


def revolved(
    profile: list[tuple[float, float, float]], corners: int, turn: float = 0.0
) -> tuple[np.ndarray, np.ndarray]:
    """A closed ring of outlines (half side x, half side y, height) around z."""
    angles = 2 * np.pi * np.arange(corners) / corners + turn
    points = [(x * np.cos(a), y * np.sin(a), z) for a in angles for x, y, z in profile]
    count, faces = len(profile), []
    for i in range(corners):
        for k in range(count):
            a, b = i * count + k, (i + 1) % corners * count + k
            c, d = (i + 1) % corners * count + (k + 1) % count, i * count + (k + 1) % count
            faces += [(a, b, c), (a, c, d)]
    return np.array(points), np.array(faces)


def ring(corners: int = 16) -> tuple[np.ndarray, np.ndarray]:
    return revolved([(8, 8, 0), (10, 10, 0), (10, 10, 4), (8, 8, 4)], corners)


def crate() -> tuple[np.ndarray, np.ndarray]:
    """An open box: four corners around, and a floor inside and outside."""
    across = [(x * 2**0.5, y * 2**0.5, z) for x, y, z in CRATE]
    points, faces = revolved(across, 4, np.pi / 4)
    kept = [f for k, f in enumerate(faces.tolist()) if (k // 2) % 4 != 3]
    floor = [(0, 12, 8), (0, 8, 4), (3, 7, 11), (3, 11, 15)]
    return points, np.array([*kept, *floor])


def as_obj(points: np.ndarray, faces: np.ndarray) -> bytes:
    lines = [f"v {x} {y} {z}" for x, y, z in points] + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in faces]
    return "\n".join(lines).encode()


def as_stl(points: np.ndarray, faces: np.ndarray) -> bytes:
    rows = [struct.pack("<12fH", 0, 0, 0, *points[face].ravel().tolist(), 0) for face in faces]
    return b"mesh".ljust(80) + struct.pack("<I", len(rows)) + b"".join(rows)


def as_ascii_stl(points: np.ndarray, faces: np.ndarray) -> bytes:
    corners = ["".join(f"vertex {x} {y} {z}\n" for x, y, z in points[face]) for face in faces]
    return ("solid m\n" + "".join(f"facet normal 0 0 0\nouter loop\n{c}endloop\nendfacet\n" for c in corners)
            + "endsolid m\n").encode()  # fmt: skip


def as_dae(points: np.ndarray, faces: np.ndarray) -> bytes:
    numbers = " ".join(map(str, points.ravel().tolist()))
    return f"""<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<library_geometries><geometry id="g"><mesh>
<source id="s"><float_array id="a" count="{points.size}">{numbers}</float_array><technique_common>
<accessor source="#a" count="{len(points)}" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#s"/></vertices>
<triangles count="{len(faces)}"><input semantic="VERTEX" source="#v" offset="0"/>
<p>{" ".join(map(str, faces.ravel()))}</p>
</triangles></mesh></geometry></library_geometries><library_visual_scenes><visual_scene id="w"><node>
<instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#w"/></scene></COLLADA>""".encode()


def test_a_closed_mesh_is_cut_into_convex_parts_that_fill_it() -> None:
    for points, faces, count in ((*crate(), 5), (*ring(), 16)):
        surface = surface_of(points, faces)
        found = cut(surface)
        assert found is not None and len(found) == count and not surface.faults()
        assert sum(map(hull_volume, found)) == pytest.approx(surface.volume, rel=1e-6)


BAD = {
    "inward": (lambda p, f: (p, f[:, ::-1]), "its 28 faces look inward, and are turned"),
    "mixed": (lambda p, f: (p, np.concatenate([f[:1, ::-1], f[1:]])), "1 of its 28 faces look inward"),
    "double": (lambda p, f: (p, np.concatenate([f, f[:, ::-1]])), "28 faces that are there twice are left out"),
    "flat": (
        lambda p, f: (np.vstack([p, p[:2].mean(axis=0)]), np.vstack([f, [0, 1, len(p)]])),
        "1 faces without an area are left out",
    ),
}


@pytest.mark.parametrize(("fault", "write"), [*zip(BAD, [as_dae, as_stl, as_ascii_stl, as_obj], strict=True)])
def test_a_bad_surface_is_told_and_what_it_holds_is_the_same(
    tmp_path: Path, fault: str, write: Callable[..., bytes]
) -> None:
    change, message = BAD[fault]
    ending = {as_obj: "obj", as_dae: "dae"}.get(write, "stl")
    (tmp_path / f"m.{ending}").write_bytes(write(*change(*crate())))
    text = f'{ROOM}task t() {{ scene room() object m: mesh("m.{ending}", 1 cm) at (9 m, 0, 0)\n' \
           "object item: sphere(2 cm) on table fact (grippable item) goal (held item) }"  # fmt: skip
    (tmp_path / "t.tamp").write_text(text)
    problem, told = compile_problem(tmp_path / "t.tamp")
    assert [d.code for d in told] == ["W0022"] and message in told[0].message
    shape = problem.world.bodies["m"].shape
    assert len(shape.parts) == 5
    assert shape.parts[0].at[2] == pytest.approx(-0.055) and max(abs(x) for x in shape.parts[0].at[:2]) < 1e-6


def test_a_hollow_box_turns_like_a_box_less_its_hollow() -> None:
    """About the middle of it, by the planner and by the verifier."""
    walls = [((x, 0.0, 0.005), (0.01, 0.24, 0.11)) for x in (-0.145, 0.145)]
    walls += [((0.0, y, 0.005), (0.28, 0.01, 0.11)) for y in (-0.115, 0.115)]
    parts = [((0.0, 0.0, -0.055), (0.30, 0.24, 0.01)), *walls]
    shape, _ = union([(at, Shape(ShapeKind.BOX, size)) for at, size in parts])

    def of_box(x: float, y: float, z: float, up: float) -> np.ndarray:
        mass = 1000.0 * x * y * z
        own = mass / 12.0 * np.diag([y * y + z * z, x * x + z * z, x * x + y * y])
        return own + mass * up * up * np.diag([1.0, 1.0, 0.0])

    wanted = of_box(0.30, 0.24, 0.12, 0.0) - of_box(0.28, 0.22, 0.11, 0.005)
    for made in (shape_moments(shape, shape_mass(shape)), moments(shape, mass_of(shape))):
        assert made == pytest.approx(wanted, rel=1e-9, abs=1e-12)


@pytest.mark.parametrize(("faces", "code", "message"), [
    (lambda f: f[:-2], "E0518", "it has holes: 4 edges have a face on one side alone"),
    (lambda f: f[:0], "E0515", "cannot be read"),
    (lambda f: f[-4:-2], "E0509", "the corners lie in a plane"),
])  # fmt: skip
def test_a_mesh_that_holds_nothing_is_refused_for_its_cause(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], faces: Callable[..., Any], code: str, message: str
) -> None:
    points, all_faces = crate()
    (tmp_path / "m.obj").write_bytes(as_obj(points, faces(all_faces)))
    (tmp_path / "t.tamp").write_text(
        f'{ROOM}task t() {{ scene room() object m: mesh("m.obj", 1 cm) at (9 m, 0, 0) '
        "object item: sphere(2 cm) on table fact (grippable item) goal (held item) }"
    )
    assert cli.run(["check", str(tmp_path / "t.tamp")]) == 1
    told = "".join(capsys.readouterr())
    assert code in told and message in told


def test_a_hand_reaches_into_a_box_and_a_ring(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Takes a thing from a box in text and puts it into a mesh, of which the plan knows the parts."""
    monkeypatch.chdir(tmp_path)
    Path("crate.stl").write_bytes(as_stl(*crate()))
    Path("ring.obj").write_bytes(as_obj(*ring()))
    Path("t.tamp").write_text(f"""{ROOM}
task boxes() {{
    scene room()
    object first: {PARTS} on table at (0, -15 cm)
    object crate: mesh("crate.stl", 1 cm) on table at (0, 15 cm)
    object item: box(4 cm, 4 cm, 4 cm) on first at (3 cm, 2 cm)
    fact (grippable item)
    fact (tray crate)
    goal (on crate item)
}}
task rings() {{
    scene room()
    object ring: mesh("ring.obj", 1 cm) on table
    object item: sphere(2 cm) on table
    fact (grippable item)
    goal (held item)
}}
""")
    for task in ("boxes", "rings"):
        assert cli.run(["solve", "t.tamp", task, "--time", "60", "-o", f"{task}.json"]) == 0
    Path("crate.stl").unlink()
    assert cli.run(["verify", "boxes.json"]) == 0
    plan = read_plan("boxes.json")
    bodies = {b.name: b for b in plan.bodies}
    assert "parts" in plan.needs and [len(bodies[n].shape.parts) for n in ("first", "crate", "item")] == [5, 5, 0]
    whole = bodies["crate"].shape
    hollow = structs.replace(bodies["crate"], shape=structs.replace(whole, parts=whole.parts[1:]))
    assert not verify(structs.replace(plan, bodies=[hollow if b.name == "crate" else b for b in plan.bodies])).verified
    item = plan.body_tracks[-1].poses[-1]
    assert bodies["crate"].pose[2] - 0.06 + 0.01 + 0.02 == pytest.approx(item[2], abs=1e-3)
    model = pytest.importorskip("mujoco").MjModel.from_xml_string(scene(plan).decode())
    names = [model.geom(k).name for k in range(model.ngeom)]
    assert sum(name.startswith("crate/part") for name in names) == 5


def test_a_hollow_link_of_a_robot_is_cut_unless_an_effector_takes_it_over(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    points, faces = crate()
    Path("crate.obj").write_bytes(as_obj(points, faces[:, ::-1]))
    Path("r.urdf").write_text("""<robot name="r"><link name="base"><collision><origin xyz="1 0 0" rpy="0 0 0"/>
        <geometry><mesh filename="crate.obj" scale="0.01 0.01 0.01"/></geometry></collision></link></robot>""")
    for end, parts in (('"base" sphere(1 cm)', 5), ('"base"', 0)):
        Path("t.tamp").write_text(f"""module r from urdf "r.urdf" {{ effector A: {end} }}
            predicate (lit)
            task t() {{ r a: at (0, 0, 0) goal (lit) }}
            rule light() {{ post (lit) }}""")
        problem, told = compile_problem("t.tamp")
        assert [w.code for w in told] == ["W0006"] and "its 28 faces look inward" in told[0].message
        assert "5 convex parts, as the shape of an effector by its hull" in told[0].message
        assert len(problem.world.modules["a"].type.links) == parts
        heights = [link.placement[2] for link in problem.world.modules["a"].type.links]
        assert min(heights, default=0.005) == pytest.approx(0.005)


def test_what_stands_on_a_body_of_parts_stands_on_the_largest_flat_top() -> None:
    legs = [((x, y, 0.0), Shape("cylinder", (0.03, 0.7))) for x in (-0.4, 0.4) for y in (-0.2, 0.2)]
    shape, middle = union([*legs, ((0.0, 0.0, 0.36), Shape("box", (1.0, 0.6, 0.02)))])
    assert shape.parts[0].shape.kind == "box" and len(shape.parts) == 5
    assert middle == pytest.approx((0.0, 0.0, 0.01))
