"""Plans carried out in MuJoCo."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tamplang.compiler.pipeline import compile_text
from tamplang.runtime.engine import contacts
from tamplang.runtime.engine.actor import Actor, fastened
from tamplang.runtime.engine.conditions import Conditions
from tamplang.runtime.plan_files import write_plan
from tamplang.runtime.planner.lgp import SolveOptions, solve

TEXT = """import std.rules

module arm {{
    effector A: gripper sphere(0.05 m) normal (0, 0, -1) mass 350 g holds pad(force 1 kN, moment 120 N m)
        holds grip(force {grip}, friction 0.6)
    joint j1: revolute(z) in -3 rad .. 3 rad torque {drive} mass 0.5 kg
    joint j2: revolute(y) in -2 rad .. 2 rad home 0.2 rad torque {drive} mass 0.5 kg
    link 0.5 m: capsule(0.04 m) mass 1 kg
    joint j3: revolute(y) in -2.5 rad .. 2.5 rad home 0.2 rad torque {drive} mass 0.5 kg
    link 0.4 m: capsule(0.04 m) mass 1 kg
    joint j4: revolute(y) in -2.5 rad .. 2.5 rad home 0.2 rad torque {drive}
    link 0.1 m: capsule(0.04 m) mass 200 g
    effector B: gripper sphere(0.05 m) mass 350 g holds pad(force 1 kN, moment 120 N m)
        holds grip(force {grip}, friction 0.6)
    fact (linked A B)
}}

task t() {{
    base ground: box(2 m, 2 m, 5 cm) at (0, 0, 0)
    object shelf: box(40 cm, 40 cm, 5 cm) at (0.5 m, 0, 0.3 m)
    object tray: box(40 cm, 40 cm, 5 cm) at (-0.5 m, 0, 0.3 m)
    object item: box(6 cm, 6 cm, 6 cm) on shelf mass 1 kg
    fact (grippable item)
    fact (tray tray)
    arm c: A on ground at (0, 0)
    goal (on tray item)
    options {{ physics = {physics}, slices = 10 }}
}}
"""


def simulated(folder: Path, drive: str, grip: str, physics: str) -> tuple[int, dict[str, object], float]:
    """Status and figures of the plan of a task, and the greatest torque that the verifier measured, if any."""
    program = TEXT.format(drive=drive, grip=grip, physics=physics)
    plan = solve(compile_text(program, "t.tamp")[0], SolveOptions(time=60.0)).plans[0]
    path = folder / "t.plan.json"
    write_plan(plan, path)
    process = subprocess.run(
        [sys.executable, "-m", "tamplang", "simulate", str(path), "--json"], capture_output=True, text=True, check=False
    )
    assert process.stdout, process.stderr
    return process.returncode, json.loads(process.stdout), plan.verdict.worst.get("torque_ratio", 0.0)


def test_a_plan_that_bears_itself_is_carried_out(tmp_path: Path) -> None:
    status, told, ratio = simulated(tmp_path, "60 N m", "200 N", "dynamics")
    assert status == 0 and told["reached"] and told["broken"] == []
    assert told["base_m"] < 1e-2 and told["tracking"] < 5e-3 and told["droop_m"] < 1e-3
    peak = max(row["peak"] for row in told["peaks"])
    assert peak == pytest.approx(ratio * 60.0 / 1.5, rel=0.05)


def test_what_is_held_too_weakly_breaks_and_the_goal_is_not_reached(tmp_path: Path) -> None:
    status, told, _ = simulated(tmp_path, "60 N m", "4 N", "none")
    assert status == 5 and not told["reached"]
    assert "item" in told["broken"][0]["what"] and told["broken"][0]["ratio"] > 1.0


def test_drives_that_are_too_weak_lose_the_arm(tmp_path: Path) -> None:
    status, told, _ = simulated(tmp_path, "6 N m", "200 N", "none")
    assert status == 5 and not told["reached"]
    assert max(row["peak"] for row in told["peaks"]) == pytest.approx(6.0)
    assert told["tracking"] > 0.1


def test_without_the_engine_the_extra_is_named(tmp_path: Path) -> None:
    plan = solve(compile_text(TEXT.format(drive="60 N m", grip="200 N", physics="none"), "t.tamp")[0],
                 SolveOptions(time=60.0)).plans[0]  # fmt: skip
    write_plan(plan, tmp_path / "t.plan.json")
    code = "import sys; sys.modules['mujoco'] = None; from tamplang.__main__ import main; main()"
    process = subprocess.run(
        [sys.executable, "-c", code, "simulate", str(tmp_path / "t.plan.json")],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert process.returncode == 1
    assert "S0012" in process.stderr and "tamplang[sim]" in process.stderr and "Traceback" not in process.stderr


def test_noise_follows_its_seed_and_feet_stand_by_contact(tmp_path: Path) -> None:
    program = TEXT.format(drive="60 N m", grip="200 N", physics="dynamics")
    plan = solve(compile_text(program, "t.tamp")[0], SolveOptions(time=60.0)).plans[0]
    path = tmp_path / "t.plan.json"
    write_plan(plan, path)

    def told(*arguments: str) -> dict[str, object]:
        command = [sys.executable, "-m", "tamplang", "simulate", str(path), "--json", *arguments]
        return json.loads(subprocess.run(command, capture_output=True, text=True, check=False).stdout)

    first = told("--contact", "--noise", "0.02", "--seed", "3")
    assert first["reached"] and first["broken"] == [] and first["base_m"] < 1e-2
    assert told("--contact", "--noise", "0.02", "--seed", "3") == first
    assert told("--contact", "--noise", "0.02", "--seed", "4") != first
    command = [sys.executable, "-m", "tamplang", "simulate", str(path), "--noise", "nan"]
    assert subprocess.run(command, capture_output=True, check=False).returncode == 2
    weak = program.replace("force 1 kN, moment 120 N m", "force 3 N, moment 0.1 N m, friction 0.6")
    problem, _ = compile_text(weak.replace("physics = dynamics, ", ""), "t.tamp")
    write_plan(solve(problem, SolveOptions(time=60.0)).plans[0], path)
    fallen = told("--contact")
    assert not fallen["reached"] and any("tipped" in b["what"] or "slipped" in b["what"] for b in fallen["broken"])


def test_without_a_display_nothing_is_shown(tmp_path: Path) -> None:
    program = TEXT.format(drive="60 N m", grip="200 N", physics="none").replace("(on tray item)", "(on shelf item)")
    path = tmp_path / "t.plan.json"
    write_plan(solve(compile_text(program, "t.tamp")[0], SolveOptions(time=60.0)).plans[0], path)
    bare = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY")}
    command = [sys.executable, "-m", "tamplang", "simulate", str(path), "--view"]
    process = subprocess.run(command, capture_output=True, text=True, check=False, env=bare)
    assert process.returncode != 0 and "S0014" in process.stderr


def test_a_simulation_that_breaks_down_is_told_and_leaves_no_file(tmp_path: Path) -> None:
    text = TEXT.format(drive="60 N m", grip="200 N", physics="none").replace("goal (on tray item)", "goal (held item)")
    text = text.replace("on shelf mass 1 kg", "on shelf mass 1000000 kg").replace("mass 1 kg", "mass 0.1 g")
    text = re.sub(r" torque 60 N m( mass 0.5 kg)?|\s+holds \w+\([^)]*\)", "", text).replace("200 g", "0.01 g")
    problem, _ = compile_text(text.replace(" mass 350 g", ""), "t.tamp")
    write_plan(solve(problem, SolveOptions(time=60.0)).plans[0], tmp_path / "t.plan.json")
    process = subprocess.run(
        [sys.executable, "-m", "tamplang", "simulate", "t.plan.json"], capture_output=True, text=True, cwd=tmp_path
    )
    assert process.returncode == 5 and process.stdout.startswith("S0013: the simulation broke down at 1.")
    assert process.stderr == "" and [p.name for p in tmp_path.iterdir()] == ["t.plan.json"]


def test_a_foot_that_lets_go_no_longer_pulls() -> None:
    problem, _ = compile_text(TEXT.format(drive="60 N m", grip="200 N", physics="none"))
    edges = fastened(problem, problem.init_motion)
    actor = Actor(problem, edges, Conditions(contact=True))
    actor.switch(edges)
    contacts.pull(actor.world, list(actor.standing.values()))
    pulled = actor.world.data.xfrc_applied[actor.world.bodies["c", -1]].copy()
    assert pulled[2] == pytest.approx(-1e3)
    actor.switch({})
    assert not actor.standing and not actor.world.data.xfrc_applied.any()
