"""Every export of five plans, written by `tamplang export` and read back by tools of others: how far what they read
lies from the plan file, in m, rad or entries of rotations.

The plans: two robots that dock, a closed loop, a mobile base, a run in a scene that moves, an arm with a mesh. PDDL
needs `unified-planning`, and is passed over without it; the others need what the tests of tamplang need.
"""

from __future__ import annotations

import argparse
import csv
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from resource import RUSAGE_CHILDREN, getrusage
from typing import Any

import numpy as np
from numpy.typing import NDArray

ROOT = Path(__file__).resolve().parents[1]
EXAMPLES = ROOT / "examples"
Array = NDArray[np.float64]
ARM = """import std.rules
module arm from urdf "arm.urdf" {
    effector base: gripper "base" box(16 cm, 16 cm, 2 cm) at (0, 0, -1 cm) normal (0, 0, -1)
    effector tool: gripper "tip" sphere(3 cm)
    fact (linked base tool)
}
task arm() {
    base ground: box(2 m, 2 m, 5 cm) at (0, 0, 0)
    object ball: sphere(4 cm) at (30 cm, 20 cm, 40 cm)
    arm a: base on ground
    fact (grippable ball)
    goal (held ball)
}
"""
WEDGE = ((-0.03, -0.03, 0.0), (0.03, -0.03, 0.0), (0.0, 0.04, 0.0), (0.0, 0.0, 0.2))


def arm(folder: Path) -> Path:
    """An arm whose links are meshes."""
    facets = "".join(
        "facet normal 0 0 0\nouter loop\n" + "".join("vertex {} {} {}\n".format(*WEDGE[i]) for i in corners)
        + "endloop\nendfacet\n" for corners in ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))
    )  # fmt: skip
    (folder / "wedge.stl").write_text(f"solid wedge\n{facets}endsolid wedge\n")
    shape = '<collision><geometry><mesh filename="wedge.stl"/></geometry></collision>'
    joint = """<joint name="j{0}" type="{5}"><parent link="{1}"/><child link="{2}"/><origin xyz="0 0 {3}"/>
        <axis xyz="{4}"/><limit lower="-2.5" upper="2.5" effort="50" velocity="2"/></joint>"""
    names, axes = ("base", "one", "two", "three", "tip"), ("0 0 1", "0 1 0", "0 1 0", "0 0 1")
    links = "".join(f'<link name="{n}">{shape if n in ("one", "two", "three") else ""}</link>' for n in names)
    joints = "".join(
        joint.format(k, names[k], names[k + 1], (0.05, 0.25, 0.25, 0.25)[k], axes[k], "fixed" if k == 3 else "revolute")
        for k in range(4)
    )
    (folder / "arm.urdf").write_text(f'<robot name="arm">{links}{joints}</robot>')
    (folder / "arm.tamp").write_text(ARM)
    return folder / "arm.tamp"


PLANS: dict[str, Callable[[Path], list[str]]] = {
    "two robots docking (climb)": lambda _: ["solve", str(EXAMPLES / "climb.tamp")],
    "closed loop (quadruped)": lambda _: ["solve", str(EXAMPLES / "quadruped.tamp")],
    "mobile base (mobile_manipulator)": lambda _: ["solve", str(EXAMPLES / "mobile_manipulator.tamp")],
    "moving scene (run of moving_stairs)": lambda _: ["run", str(EXAMPLES / "moving_stairs.tamp")],
    "mesh arm": lambda folder: ["solve", str(arm(folder))],
}


class Told:
    """What a plan file says, read as plain JSON."""

    def __init__(self, file: Path) -> None:
        self.plan: dict[str, Any] = json.loads(file.read_text())
        self.file = file
        stamps = np.array(self.plan["times"])
        self.kept = np.concatenate([[True], np.diff(stamps) > 0])
        self.times = stamps[self.kept]
        rows = {t["name"]: np.array(t["joints"]).reshape(len(stamps), -1) for t in self.plan["tracks"]}
        self.joints = {name: row[self.kept] for name, row in rows.items()}
        self.poses = {t["name"]: np.array(t["poses"])[self.kept] for t in self.plan["tracks"]}
        self.names = {m["name"]: [j["name"] for j in m["joints"]] for m in self.plan["modules"]}

    def at(self, stamps: Array) -> NDArray[np.intp]:
        """Which samples these times are; all are some."""
        found = np.clip(np.searchsorted(self.times, stamps - 1e-7), 0, len(self.times) - 1)
        assert np.abs(self.times[found] - stamps).max(initial=0.0) < 1e-6, "a time that the plan does not have"
        return found


def matrices(poses: Array) -> Array:
    """Rotations and places (N, 3, 4) of poses."""
    from scipy.spatial.transform import Rotation

    return np.concatenate([Rotation.from_quat(poses[:, 3:]).as_matrix(), poses[:, :3, None]], axis=2)


def in_csv(told: Told, file: Path) -> float:
    """By Python's csv."""
    with file.open(newline="") as stream:
        rows = list(csv.DictReader(stream))
    wrong = [np.abs(np.array([float(r["time"]) for r in rows]) - told.times).max()]
    for module, values in told.joints.items():
        read = np.array([[float(r[f"{module}.{n}"]) for n in told.names[module]] for r in rows]).reshape(values.shape)
        wrong.append(np.abs(read - values).max(initial=0.0))
    return float(max(wrong))


def in_npz(told: Told, file: Path) -> float:
    """By NumPy."""
    with np.load(file) as arrays:
        wrong = [np.abs(arrays["time"] - told.times).max()]
        for module, values in told.joints.items():
            wrong.append(np.abs(arrays[f"{module}/q"] - values).max(initial=0.0))
            wrong.append(np.abs(matrices(arrays[f"{module}/poses"]) - matrices(told.poses[module])).max())
    return float(max(wrong))


def in_ros2(told: Told, file: Path) -> float:
    """By PyYAML, within the rules of the joint trajectory controller."""
    import yaml

    wrong = [0.0]
    for message in yaml.load_all(file.read_text(), yaml.CSafeLoader):
        points, module = message["trajectory"]["points"], message["module"]
        since = [p["time_from_start"]["sec"] + 1e-9 * p["time_from_start"]["nanosec"] for p in points]
        assert since[0] > 0 and min(np.diff(since), default=1.0) > 0 and not any(points[-1]["velocities"])
        assert message["trajectory"]["joint_names"] == [f"{module}.{n}" for n in told.names[module]]
        read = np.array([p["positions"] for p in points])
        wrong.append(np.abs(read - told.joints[module][told.at(np.array(since) + message["start"])]).max())
    return float(max(wrong))


def in_mcap(told: Told, file: Path) -> float:
    """By the package mcap, which decodes messages by the definitions in the bag."""
    from mcap.reader import make_reader
    from mcap_ros2.decoder import DecoderFactory

    first = {f"{m}.{names[0]}": m for m, names in told.names.items() if names}
    wrong = [0.0]
    with file.open("rb") as stream:
        for _, _, message, decoded in make_reader(stream, decoder_factories=[DecoderFactory()]).iter_decoded_messages():
            since = np.array([p.time_from_start.sec + 1e-9 * p.time_from_start.nanosec for p in decoded.points])
            rows = told.at(since + message.log_time * 1e-9)
            if hasattr(decoded.points[0], "positions"):
                read = np.array([p.positions for p in decoded.points])
                wrong.append(np.abs(read - told.joints[first[decoded.joint_names[0]]][rows]).max())
                continue
            for k, name in enumerate(decoded.joint_names):
                parts = [p.transforms[k] for p in decoded.points]
                read = np.array([
                    [t.translation.x, t.translation.y, t.translation.z, *(getattr(t.rotation, a) for a in "xyzw")]
                    for t in parts
                ])  # fmt: skip
                if name in told.poses:
                    wrong.append(np.abs(matrices(read) - matrices(told.poses[name][rows])).max())
    return float(max(wrong))


def in_urdf(told: Told, file: Path) -> float:
    """By Pinocchio: where the modules of the robot lie, from its first one, at the end of the plan."""
    import pinocchio

    model = pinocchio.buildModelFromUrdf(str(file))
    data, values = model.createData(), pinocchio.neutral(model)
    inside = [m for m in told.names if model.existFrame(m) and m in told.poses]
    for module in inside:
        for name, value in zip(told.names[module], told.joints[module][-1], strict=True):
            values[model.joints[model.getJointId(f"{module}.{name}")].idx_q] = value
    pinocchio.framesForwardKinematics(model, data, values)
    whole = np.array([[0.0, 0.0, 0.0, 1.0]])
    stand = {m: np.concatenate([matrices(told.poses[m][-1:])[0], whole]) for m in inside}
    wrong = [0.0]
    for module in inside:
        found = data.oMf[model.getFrameId(module)].homogeneous
        base = data.oMf[model.getFrameId(inside[0])].homogeneous
        wrong.append(np.abs(np.linalg.solve(base, found) - np.linalg.solve(stand[inside[0]], stand[module])).max())
    return float(max(wrong))


def in_mjcf(told: Told, file: Path) -> float:
    """By MuJoCo: the modules at each key frame, up to a hundred of them."""
    import mujoco

    model = mujoco.MjModel.from_xml_path(str(file))
    data, wrong = mujoco.MjData(model), [0.0]
    assert model.nkey == len(told.times)
    for key in np.unique(np.linspace(0, model.nkey - 1, 100).astype(int)):
        mujoco.mj_resetDataKeyframe(model, data, int(key))
        mujoco.mj_kinematics(model, data)
        for module, poses in told.poses.items():
            body = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, module)
            found = np.column_stack([data.xmat[body].reshape(3, 3), data.xpos[body]])
            wrong.append(np.abs(found - matrices(poses[key : key + 1])[0]).max())
    return float(max(wrong))


def in_pddl(told: Told, file: Path) -> str:
    """By unified-planning, whose validator is given the plan as well."""
    try:
        from unified_planning.io import PDDLReader
        from unified_planning.shortcuts import PlanValidator, get_environment
    except ImportError:
        return "–"
    get_environment().credits_stream = None
    reader = PDDLReader()
    problem = reader.parse_problem(str(file.with_name(f"{file.stem}-domain.pddl")), str(file))
    plan = reader.parse_plan(problem, str(file.with_suffix(".val")))
    with PlanValidator(problem_kind=problem.kind) as validator:
        return str(validator.validate(problem, plan).status.name).lower()


def in_pictures(told: Told, file: Path) -> str:
    """By Pillow, or ffmpeg: how many pictures there are; all of one size, and moving."""
    if file.suffix == ".mp4":
        import imageio_ffmpeg

        return f"{imageio_ffmpeg.count_frames_and_secs(str(file))[0]} pictures"
    from PIL import Image

    with Image.open(file) as picture:
        count = getattr(picture, "n_frames", 1)
        assert picture.size == (960, 540) and (file.suffix == ".png" or count > 1)
        return f"{count} picture{'s' if count > 1 else ''}"


READERS: dict[str, tuple[str, Callable[[Told, Path], float | str]]] = {
    "csv": (".csv", in_csv), "npz": (".npz", in_npz), "ros2": (".yaml", in_ros2), "mcap": (".mcap", in_mcap),
    "urdf": (".urdf", in_urdf), "mjcf": (".xml", in_mjcf), "val": (".val", lambda *_: "with pddl"),
    "pddl": (".pddl", in_pddl), "png": (".png", in_pictures), "gif": (".gif", in_pictures),
    "mp4": (".mp4", in_pictures),
}  # fmt: skip


def tamplang(*arguments: str, folder: Path) -> float:
    """One command, as users give it; its CPU seconds. Raises CalledProcessError."""
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    before = getrusage(RUSAGE_CHILDREN).ru_utime
    subprocess.run([sys.executable, "-m", "tamplang", *arguments], cwd=folder, env=environment, check=True,
                   capture_output=True)  # fmt: skip
    return getrusage(RUSAGE_CHILDREN).ru_utime - before


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(prog="tamplang bench exports", description=__doc__)
    parser.parse_args()
    print("| plan | actions | " + " | ".join(READERS) + " | longest, CPU s |")
    print("|---" * (len(READERS) + 3) + "|")
    for name, make in PLANS.items():
        with tempfile.TemporaryDirectory() as place:
            folder = Path(place)
            tamplang(*make(folder), "-o", str(folder / "a.plan.json"), folder=folder)
            told, cells, longest = Told(folder / "a.plan.json"), [], (0.0, "")
            for form, (ending, read) in READERS.items():
                file = folder / f"a{ending}"
                seconds = tamplang("export", str(told.file), "--to", form, "-o", str(file), folder=folder)
                longest = max(longest, (seconds, form))
                found = read(told, file)
                cells.append(found if isinstance(found, str) else f"{found:.0e}" if found else "0")
        print(f"| {name} | {len(told.plan['phases'])} | " + " | ".join(cells) + f" | {longest[0]:.1f} ({longest[1]}) |",
              flush=True)  # fmt: skip


if __name__ == "__main__":
    main()
