"""A share of `tamplang bench trust --part tamper`: wrong plans are refused, true ones accepted, by both checkers."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path

import pytest

from benchmarks.trust import tamper
from benchmarks.trust.checker import judge, read
from benchmarks.trust.journal import Settings
from benchmarks.trust.kinds import KINDS
from benchmarks.trust.plans import verdict

BASES = ["climb", "own", "gone", "lost", "urdf"]
COUNT = len(KINDS)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("trust")


@pytest.fixture(scope="module")
def texts(folder: Path) -> dict[str, str]:
    return tamper.base_texts(Settings(folder), BASES)


def test_good_plans_are_accepted_by_both_checkers(texts: dict[str, str], tmp_path: Path) -> None:
    for name, text in texts.items():
        file = tmp_path / "plan.json"
        file.write_text(text)
        assert verdict(file)["said"] == ("unfinished" if name == "lost" else "verified"), name
        assert judge(read(text)) == [], name


def test_no_wrong_plan_is_accepted(texts: dict[str, str], folder: Path) -> None:
    settings = Settings(folder, seed=0, count=COUNT)
    lines = tamper.run(settings, BASES)
    assert [line.kept for line in lines] == [True, True], lines
    records = [json.loads(row) for row in (folder / "tamper.jsonl").read_text().splitlines()]
    said = Counter(r["said"] for r in records)
    assert said["refused"] + said["unreadable"] > COUNT // 2 and said["verified"] > 5
    assert len({r["key"].split("/")[0] for r in records if r["said"] != "unfit"}) >= 60


@pytest.mark.parametrize(
    ("name", "kinds"),
    [
        ("joint_of_a_sample", {"spline_rad"}),
        ("acceleration_over_its_limit", {"joint_acceleration"}),
        ("phase_in_a_blink", {"joint_speed", "joint_acceleration"}),
        ("foot_slips", {"slip_m", "rest_m"}),
        ("last_phase_missing", {"goal", "literals"}),
        ("mode_lacks_a_literal", {"literals"}),
        ("link_thinner", {"scene"}),
        ("hash_changed", {"structure"}),
    ],
)
def test_second_checker_sees_it_by_itself(texts: dict[str, str], name: str, kinds: set[str]) -> None:
    changed = tamper.tampered(texts["climb"], KINDS[name], "5")
    assert changed is not None
    assert {f.kind for f in judge(read(changed))} & kinds


def test_second_checker_sees_what_goes_through_a_body_between_crowded_samples(texts: dict[str, str]) -> None:
    found = set()
    for seed in range(8):
        changed = tamper.tampered(texts["climb"], KINDS["detour_between_crowded_samples"], str(seed))
        assert changed is not None
        found |= {f.kind for f in judge(read(changed))}
    assert "penetration_m" in found


def test_second_checker_imports_nothing_of_the_runtime() -> None:
    import subprocess
    import sys

    code = "import sys, benchmarks.trust.checker; print([m for m in sys.modules if m.startswith('tamplang.runtime')])"
    root = Path(tamper.__file__).parents[2]
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=root, check=True)
    assert done.stdout.strip() == "[]"


def test_results_are_kept_and_gone_on_with(tmp_path: Path) -> None:
    journal = Settings(tmp_path).journal("part")
    assert [r["n"] for r in journal.fill(["a", "b"], lambda key: {"n": ord(key)})] == [97, 98]
    with journal.path.open("a") as file:
        file.write('{"key": "c", "n"')
    again = Settings(tmp_path, resume=True).journal("part")
    assert [r["n"] for r in again.fill(["a", "b", "c"], lambda key: {"n": 0})] == [97, 98, 0]
    assert len(journal.path.read_text().splitlines()) == 3
