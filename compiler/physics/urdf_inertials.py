"""The `inertial` elements of a URDF. One of mass 0 says nothing, as in files that only draw."""

from __future__ import annotations

import math
from collections.abc import Mapping
from xml.etree import ElementTree

from ..ir import Pose
from ..poses import compose, make, orientation, rotate
from ..urdf_files import three, turned
from .records import Inertial

HEAVIEST = 1e6
"""Kilograms; see `statements.LARGEST`."""
SWEEPS = 12
"""Of Jacobi's method, whose error squares with each: 6 are enough for doubles."""
SLACK = 1e-6
"""Share by which rounded moments of inertia may break the inequality of triangles."""


class UnfitInertia(Exception):
    """An `inertial` that no body can have; the message says why."""

    def __init__(self, message: str, help: str | None = None) -> None:
        super().__init__(message)
        self.help = help


def read_inertial(
    link: ElementTree.Element, frames: Mapping[str, tuple[int, Pose]], newer: bool
) -> Inertial | None:
    """What a link states. `frames` tell the joint that carries a link, and the link's frame on it; `newer` that
    quaternions count. Raises UnfitInertia."""
    element, name = link.find("inertial"), link.get("name", "")
    if element is None:
        return None
    if element.find("mass") is None:
        raise UnfitInertia(f"the inertial of link `{name}` has no `mass`")
    mass = _number(element.find("mass"), "value", name)
    if mass == 0.0:
        return None
    if not 0.0 < mass <= HEAVIEST:
        raise UnfitInertia(f"link `{name}` has a mass of {mass:g} kg", "a mass is positive, up to 1e6 kg")
    origin = element.find("origin")
    try:
        place = make(three(origin, "xyz"), turned(origin, newer))
    except ValueError as error:
        raise UnfitInertia(f"the inertial of link `{name}` has no place: {error}") from None
    joint, frame = frames[name]
    whole = compose(frame, place)
    return Inertial(joint, mass, whole[:3], _turned(_moments(element, name), whole))


def _moments(element: ElementTree.Element, name: str) -> list[list[float]]:
    """The matrix of inertia about the centre, in the frame of the inertial."""
    given = element.find("inertia")
    if given is None:
        return [[0.0] * 3 for _ in range(3)]
    xx, yy, zz = (_number(given, key, name) for key in ("ixx", "iyy", "izz"))
    xy, xz, yz = (_number(given, key, name, "0") for key in ("ixy", "ixz", "iyz"))
    matrix = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
    least, middle, most = _principal(matrix)
    if not (least >= -SLACK * abs(most) and most <= (least + middle) * (1.0 + SLACK) + 1e-12):
        told = f"{least:.3g}, {middle:.3g} and {most:.3g} kg m^2"
        raise UnfitInertia(
            f"no body has the inertia of link `{name}`: principal moments of {told}",
            "none is negative, and none is more than the sum of the two others",
        )
    return matrix


def _principal(matrix: list[list[float]]) -> list[float]:
    """The eigenvalues of a symmetric matrix (3, 3), ascending, by Jacobi's rotations, without what takes a tenth of a
    second to load."""
    m = [list(row) for row in matrix]
    for _ in range(SWEEPS):
        for p, q, r in ((0, 1, 2), (0, 2, 1), (1, 2, 0)):
            if m[p][q] == 0.0:
                continue
            steep = (m[q][q] - m[p][p]) / (2.0 * m[p][q])
            t = math.copysign(1.0, steep) / (abs(steep) + math.hypot(1.0, steep))
            cosine = 1.0 / math.hypot(1.0, t)
            sine, turned = t * cosine, t * m[p][q]
            m[p][p], m[q][q] = m[p][p] - turned, m[q][q] + turned
            m[p][q] = m[q][p] = 0.0
            one, other = m[p][r], m[q][r]
            m[p][r] = m[r][p] = cosine * one - sine * other
            m[q][r] = m[r][q] = sine * one + cosine * other
    return sorted(m[k][k] for k in range(3))


def _turned(matrix: list[list[float]], pose: Pose) -> tuple[float, float, float, float, float, float]:
    """R I Rᵀ, its upper triangle row by row."""
    turn = orientation(pose)
    half = [rotate(turn, (r[0], r[1], r[2])) for r in matrix]
    columns = [rotate(turn, (half[0][k], half[1][k], half[2][k])) for k in range(3)]
    return columns[0][0], columns[1][0], columns[2][0], columns[1][1], columns[2][1], columns[2][2]


def _number(element: ElementTree.Element | None, key: str, link: str, default: str | None = None) -> float:
    text = default if element is None else element.get(key, default)
    try:
        value = float(text or "")
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise UnfitInertia(f"`{key}` of the inertial of link `{link}` is not a number: {text}")
    return value


