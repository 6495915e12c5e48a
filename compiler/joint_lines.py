"""How the joints of a module follow each other, from a part to the module frame."""

from __future__ import annotations

from collections.abc import Set

from .ir import ModuleType


def line(type_: ModuleType, joint: int) -> list[int]:
    """The joints from this one up to the module frame, which is -1."""
    found = [joint]
    while found[-1] >= 0:
        found.append(type_.joints[found[-1]].parent)
    return found


def are_close(type_: ModuleType, one: int, other: int) -> bool:
    """Whether at most one joint lies between what two joints carry."""
    return one == other or other in line(type_, one)[:2] or one in line(type_, other)[:2]


def are_kept_apart(type_: ModuleType, one: int, other: int) -> bool:
    """Whether what two joints carry may be in each other's way: another part lies between them along the joints."""
    if one == other:
        return False
    first, second = line(type_, one), line(type_, other)
    common = next(j for j in first if j in second)
    between = (set(first) ^ set(second) | {common}) - {one, other}
    return bool(between & bearing(type_))


def bearing(type_: ModuleType) -> Set[int]:
    """The joints that carry shapes; -1 is the module frame."""
    ends = {e.joint for e in type_.effectors if e.shape is not None}
    return ends | {link.joint for link in type_.links}
