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
