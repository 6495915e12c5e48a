"""A library that the system lacks gives a sentence and a hint."""

from __future__ import annotations

from pathlib import Path

import pytest

from tamplang.runtime.native import MissingLibrary, load_coal, load_native, load_pinocchio


@pytest.mark.parametrize(
    ("reason", "hint"),
    [
        ("libgomp.so.1: cannot open shared object file: No such file or directory", "apt-get install libgomp1"),
        ("undefined symbol: _ZN5eigen", "pip install --force-reinstall some-package"),
    ],
)
def test_missing_library_has_a_hint(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, reason: str, hint: str
) -> None:
    (tmp_path / "lacking.py").write_text(f"raise ImportError({reason!r})\n")
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(MissingLibrary) as caught:
        load_native("lacking", "some-package")
    assert hint in caught.value.hint
    assert str(caught.value) == f"cannot load lacking: {reason}"


def test_libraries_load() -> None:
    assert load_pinocchio().__version__ and load_coal().__version__
