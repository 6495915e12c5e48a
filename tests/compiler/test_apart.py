"""Long calls in a process of their own: the same answer, the same errors, and an end that comes from outside."""

from __future__ import annotations

import os
import time
from pathlib import Path

import numpy as np
import pytest

from tamplang.compiler import hulls
from tamplang.compiler.apart import apart
from tamplang.compiler.mesh_files import LONG, read_mesh
from tamplang.compiler.pipeline import check
from tamplang.compiler.xml_texts import XmlError
from tamplang.runtime.budget import OutOfTime
from tamplang.runtime.guard import guarded


def _children() -> list[str]:
    return Path(f"/proc/self/task/{os.getpid()}/children").read_text(encoding="ascii").split()


def test_answers_and_errors_come_back() -> None:
    assert apart(lambda: [1, "two", 3.0]) == [1, "two", 3.0]
    with pytest.raises(ValueError, match="no body"):
        apart(lambda: (_ for _ in ()).throw(ValueError("no body")))
    with pytest.raises(MemoryError):
        apart(lambda: os._exit(1))


def test_the_end_of_the_time_ends_the_process() -> None:
    before = _children()
    with pytest.raises(OutOfTime), guarded(0.1, None):
        apart(lambda: time.sleep(600))
    assert _children() == before


class _Slow:
    """A member that takes its time when its class is made, as some do while a library is imported."""

    def __set_name__(self, owner: type, name: str) -> None:
        time.sleep(0.3)


class _SlowBelow(_Slow):
    """The same, where what it calls takes the time, as with members of enumerations that have a `__new__`."""

    def __set_name__(self, owner: type, name: str) -> None:
        self._wait(0.3)

    def _wait(self, seconds: float) -> None:
        time.sleep(seconds)


@pytest.mark.parametrize("member", [_Slow(), _SlowBelow()])
def test_the_end_of_the_time_while_a_class_is_made_is_told_as_such(member: _Slow) -> None:
    with pytest.raises(OutOfTime), guarded(0.1, None):
        type("Made", (), {"member": member})
        time.sleep(600)


def test_large_meshes_are_read_as_small_ones_are(tmp_path: Path) -> None:
    points = np.random.default_rng(0).normal(size=(hulls.LONG + 1, 3))
    few = points[:2000]
    text = "".join(f"v {x} {y} {z}\n" for x, y, z in points.tolist())
    corners = hulls.corners_of(few)
    assert np.array_equal(hulls.corners_of(points), hulls.corners_of(points[np.sort(hulls._hull_of(points)[0])]))
    faces = "".join(f"f {k} {k + 1} {k + 2}\n" for k in range(1, len(points) - 1)) * 4
    assert len((text + faces).encode()) > LONG and len(corners) < 2000
    read, triangles = read_mesh("ball.obj", (text + faces).encode())
    assert len(triangles) == 4 * (len(points) - 2) and np.allclose(read[triangles[0]], points[:3])


DAE = """<?xml version="1.0" encoding="ENCODING"?>DOCTYPE
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="a" count="12">0 0 0 1 0 0 0 1 0 0 0 1</float_array><technique_common>
<accessor source="#a" count="4" stride="3"><param name="X" type="float"/><param name="Y" type="float"/>
<param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="4"><input semantic="VERTEX" source="#v" offset="0"/><p>0 2 1 0 1 3 1 2 3 0 3 2</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="s"><node><instance_geometry url="#g"/></node></visual_scene>
</library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>
"""
NONE = "<!-- no <!DOCTYPE> and no <!ENTITY> -->"
TYPES = ("<!DOCTYPE COLLADA>", '<!DOCTYPE COLLADA [<!ENTITY a "b">]>', '<!-- a --><!DOCTYPE c SYSTEM "file:///etc/passwd">')


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16"])
def test_collada_files_declare_no_document_type(encoding: str) -> None:
    text = DAE.replace("ENCODING", encoding)
    if encoding == "utf-8":
        assert len(read_mesh("a.dae", text.replace("DOCTYPE", NONE, 1).encode(encoding))[1]) == 4
    for declared in TYPES:
        with pytest.raises(XmlError, match="document type"):
            read_mesh("a.dae", text.replace("DOCTYPE", declared, 1).encode(encoding))
    with pytest.raises(XmlError, match="document type"):  # not XML, but others may read on
        read_mesh("a.dae", f"<?xml?>{TYPES[1]}{text.partition('?>')[2]}".encode(encoding))


def test_a_document_type_in_a_mesh_is_told(tmp_path: Path) -> None:
    (tmp_path / "b.dae").write_text(DAE.replace("ENCODING", "utf-8").replace("DOCTYPE", TYPES[1], 1), encoding="utf-8")
    (tmp_path / "a.tamp").write_text('task t() { object b: hull("b.dae") at (0, 0, 0) goal (a) }', encoding="utf-8")
    told = next(d for d in check(tmp_path / "a.tamp") if d.code == "E0515")
    assert "document type" in told.message and told.span is not None
