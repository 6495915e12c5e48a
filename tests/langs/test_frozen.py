"""Records behave as the frozen dataclasses with slots of the standard library, made beside them here."""

from __future__ import annotations

import copy
import dataclasses
import inspect
import pickle
import sys
from typing import Any

import pytest

from tamplang.langs.frozen import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Base:
    span: int | None = dataclasses.field(default=None, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class Thing(Base):
    name: str
    parts: tuple[int, ...] = ()
    notes: list[int] = dataclasses.field(default_factory=list, hash=False)
    size: int = dataclasses.field(init=False, default=7)

    def __post_init__(self) -> None:
        if self.name == "bad":
            raise ValueError(self.name)


@dataclasses.dataclass(frozen=True, slots=True, kw_only=True)
class StandardBase:
    span: int | None = dataclasses.field(default=None, compare=False, repr=False)


@dataclasses.dataclass(frozen=True, slots=True)
class Standard(StandardBase):
    name: str
    parts: tuple[int, ...] = ()
    notes: list[int] = dataclasses.field(default_factory=list, hash=False)
    size: int = dataclasses.field(init=False, default=7)


def _made(cls: type[Any]) -> list[Any]:
    return [cls("a"), cls("a", span=3), cls("a", (1, 2)), cls(name="b", parts=(1, 2), notes=[4], span=1)]


def test_equality_hash_and_text_are_those_of_the_standard_library() -> None:
    mine, theirs = _made(Thing), _made(Standard)
    for i, left in enumerate(mine):
        assert repr(left) == repr(theirs[i]).replace("Standard", "Thing") and hash(left) == hash(theirs[i])
        assert [left == right for right in mine] == [theirs[i] == right for right in theirs]
        assert left != theirs[i]
    assert mine[0].notes is not mine[1].notes and not hasattr(mine[0], "__dict__")


def test_records_cannot_be_changed_and_can_be_replaced_matched_and_kept() -> None:
    thing = Thing("a", (1,), span=2)
    for change in (lambda: setattr(thing, "name", "b"), lambda: delattr(thing, "name")):
        with pytest.raises(dataclasses.FrozenInstanceError):
            change()
    assert dataclasses.replace(thing, name="c").name == "c" and dataclasses.replace(thing, name="c").span == 2
    for again in (pickle.loads(pickle.dumps(thing)), copy.copy(thing), copy.deepcopy(thing)):
        assert again == thing and again.span == 2 and again.size == 7
    match thing:
        case Thing(name, (1,)):
            assert name == "a"
        case _:
            pytest.fail("not matched")
    assert [f.name for f in dataclasses.fields(thing)] == [f.name for f in dataclasses.fields(Standard("a"))]


def test_wrong_arguments_are_errors_and_checks_are_made() -> None:
    make: Any = Thing
    for arguments, named in (((), {}), (("a", (), [], 3), {}), (("a",), {"size": 3}), (("a",), {"what": 3})):
        with pytest.raises(TypeError):
            make(*arguments, **named)
    with pytest.raises(ValueError):
        Thing("bad")


def test_every_frozen_record_of_the_language_is_made_here() -> None:
    """A class that goes the long way costs each start of the program half a millisecond."""
    import tamplang.compiler.pipeline  # noqa: F401

    slow = [
        f"{module}.{name}"
        for module, found in list(sys.modules.items())
        if module.startswith(("tamplang.langs", "tamplang.compiler"))
        for name, cls in vars(found).items()
        if inspect.isclass(cls) and cls.__module__ == module and dataclasses.is_dataclass(cls)
        and hasattr(cls, "__slots__") and getattr(cls, "__dataclass_params__").frozen  # noqa: B009
    ]  # fmt: skip
    assert slow == []
