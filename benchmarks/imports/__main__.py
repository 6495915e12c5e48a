"""How many files of others become programs, and whether outside readers agree with what comes of them.

Without folders the models that the bench makes itself are tried, and PDDL domains; `bench imports FOLDER…` tries all
files of known kinds below the folders, which are not copied. URDFs are held against Pinocchio, MJCF against MuJoCo,
link by link in random configurations (1e-9). What no outside reader is at hand for counts as accepted only.
"""

from __future__ import annotations

import argparse
import math
import re
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from random import Random
from xml.etree.ElementTree import Element

sys.path.insert(0, str(Path(__file__).parent))

import made
from domains import DOMAINS

from tamplang.compiler.importing.kinds import kind_of
from tamplang.compiler.importing.reading import import_files
from tamplang.compiler.ir import IDENTITY
from tamplang.compiler.pipeline import check, compile_problem
from tamplang.compiler.poses import compose, inverse, joint_frames
from tamplang.compiler.xml_texts import XmlError, decoded, read_xml
from tamplang.langs.diagnostics import SourceError

CLOSE = 1e-9
ROUNDS = 3


@dataclass(slots=True)
class Row:
    """What came of the files of one kind. `judged` of the accepted were held against an outside reader."""

    files: int = 0
    accepted: int = 0
    judged: int = 0
    right: int = 0
    seconds: float = 0.0
    refused: Counter[str] = field(default_factory=Counter)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(prog="tamplang bench imports", description=__doc__)
    parser.add_argument("folders", nargs="*", type=Path)
    parser.add_argument("--show", action="store_true", help="name each file that is refused or wrong, and why")
    arguments = parser.parse_args()
    rows: dict[str, Row] = {}
    with tempfile.TemporaryDirectory() as folder:
        own = Path(folder)
        named = "made by the bench" if not arguments.folders else ", ".join(map(str, arguments.folders))
        if not arguments.folders:
            made.write(own / "set")
            _pddl(own, rows.setdefault("PDDL", Row()))
        for file in _files(arguments.folders or [own / "set"]):
            kind = kind_of(str(file))
            if kind is None or kind.key not in ("urdf", "mjcf", "sdf", "rai", "modules"):
                continue
            row = rows.setdefault(kind.name, Row())
            row.files, wrong = row.files + 1, row.judged - row.right
            start = time.process_time()
            reason = _tried(file, kind.key, own, row)
            row.seconds += time.process_time() - start
            if reason is not None:
                row.refused[reason[:60]] += 1
                if arguments.show:
                    print(f"{file}: {reason}", flush=True)
            elif arguments.show and row.judged - row.right > wrong:
                print(f"{file}: parts lie elsewhere than an outside reader has them", flush=True)
    print(f"files: {named}")
    print(f"{'format':42} {'files':>6} {'accepted':>9} {'judged':>7} {'right':>6} {'CPU s':>6}  refused, by reason")
    for name, row in sorted(rows.items()):
        why = "; ".join(f"{count} {reason}" for reason, count in row.refused.most_common(4)) or "–"
        print(f"{name:42} {row.files:6} {row.accepted:9} {row.judged:7} {row.right:6} {row.seconds:6.1f}  {why}")


def _files(folders: list[Path]) -> Iterator[Path]:
    endings = (".urdf", ".xml", ".sdf", ".mjcf", ".g", ".json")
    for folder in folders:
        yield from sorted(f for f in folder.rglob("*") if f.suffix in endings and f.is_file())


def _pddl(own: Path, row: Row) -> None:
    for domain, make, sizes in DOMAINS.values():
        (own / "d.pddl").write_text(domain)
        (own / "p.pddl").write_text(make(sizes[0], 1))
        row.files += 1
        try:
            (own / "t.tamp").write_text(import_files([str(own / "d.pddl"), str(own / "p.pddl")]).text)
            row.accepted += not any(found.is_error for found in check(own / "t.tamp"))
        except SourceError as error:
            row.refused[error.diagnostics[0].message[:60]] += 1


def _tried(file: Path, key: str, own: Path, row: Row) -> str | None:
    """Why a file is refused; None where it is not. The row counts it, and whether it is right."""
    target = own / "out.tamp"
    try:
        if key == "urdf":
            target = file.with_name(file.name)
            return _urdf(file, own, row)
        found = import_files([str(file)], "out")
        for name, text in found.beside.items():
            (own / name).write_text(text)
        target.write_text(found.text)
    except SourceError as error:
        return f"{error.diagnostics[0].code} {error.diagnostics[0].message}"
    wrong = next((d for d in check(target) if d.is_error), None)
    if wrong is not None:
        return f"what was written does not check: {wrong.code} {wrong.message}"
    row.accepted += 1
    if key == "mjcf":
        row.judged += 1
        row.right += _as_mujoco(file, [text for name, text in found.beside.items()])
    return None


def _urdf(file: Path, own: Path, row: Row) -> str | None:
    """A module of a URDF, with limits for joints that have none, as its message asks."""
    try:
        root = read_xml(decoded(file.read_bytes()).decode())
    except XmlError as error:
        return f"E0513 {error}"
    links = [link.get("name", "") for link in root.findall("link")]
    ends = {f"e{k}": f'"{name}" sphere(1 mm)' for k, name in enumerate(links)}
    more = ""
    for joint in root.findall("joint"):
        if joint.get("type") in ("revolute", "prismatic") and _limitless(joint.find("limit")):
            more += f'joint "{joint.get("name")}" in ' + (
                "-1 rad .. 1 rad\n" if joint.get("type") == "revolute" else "-1 m .. 1 m\n"
            )
    program = own / "u.tamp"
    wrong = None
    while ends:
        shown = "\n".join(f"effector {end}: {what}" for end, what in ends.items())
        program.write_text(f"""predicate (lit)
rule light() {{ pre not (lit) post (lit) }}
module r from urdf "{file.resolve()}" {{ {shown}
{more} }}
task t() {{ r a: at (0, 0, 0) goal (lit) }}""")
        wrong = next((d for d in check(program) if d.is_error), None)
        named = [] if wrong is None else [e for e in re.findall(r"\be\d+\b", wrong.message) if e in ends]
        if not named:
            break
        del ends[named[0]]  # an end of the bench's own that lies in another link
    if not ends:
        return "there is no link"
    if wrong is not None:
        return f"{wrong.code} {wrong.message.replace(str(file), file.name)}"
    row.accepted += 1
    right = _as_pinocchio(program, file, links)
    row.judged += right is not None
    row.right += right is True
    return None


def _limitless(limit: Element | None) -> bool:
    """Whether a joint lacks limits, or has them the wrong way round, as Bullet writes what moves freely."""
    ends = [None if limit is None else limit.get(end) for end in ("lower", "upper")]
    try:
        return ends == [None, None] or float(ends[0] or 0) > float(ends[1] or 0)
    except ValueError:
        return False


def _still(robot: Element, name: str, lower: float) -> float:
    """Where the joint `name`, which does not move, stands."""
    mimic = robot.find(f"joint[@name={name!r}]/mimic")
    if mimic is None:
        return lower
    leader = mimic.get("joint", "")
    limit = robot.find(f"joint[@name={leader!r}]/limit")
    factor, offset = float(mimic.get("multiplier", "1")), float(mimic.get("offset", "0"))
    at = 0.0 if limit is None else float(limit.get("lower", "0"))
    return offset + (factor * _still(robot, leader, at) if factor else 0.0)


def _as_pinocchio(program: Path, file: Path, links: list[str]) -> bool | None:
    """Whether each link lies where Pinocchio has it; None where Pinocchio does not take the file."""
    import pinocchio

    module = compile_problem(program, None, {}, 0)[0].world.modules["a"].type
    try:
        model = pinocchio.buildModelFromUrdf(str(file))
    except (ValueError, RuntimeError):
        return None
    data, draw = model.createData(), Random(1)
    robot = read_xml(decoded(file.read_bytes()).decode())
    names = [j.name for j in module.joints]
    for _ in range(ROUNDS):
        values = {name: draw.uniform(-1, 1) for name in names}
        for joint in module.joints:
            if joint.follows is not None:  # Pinocchio, asked without `mimic`, has a value for each
                leader = values[names[joint.follows.leader]]
                values[joint.name] = joint.follows.factor * leader + joint.follows.offset
        q = pinocchio.neutral(model)
        for name, joint in list(zip(model.names, model.joints, strict=True))[1:]:
            if joint.nq == 1 and name in values:
                q[joint.idx_q] = values[name]
            elif joint.nq == 2 and name in values:
                q[joint.idx_q : joint.idx_q + 2] = math.cos(values[name]), math.sin(values[name])
            elif joint.nq > 2 and f"{name}.x" in values:
                for part in [n for n in values if n.startswith(f"{name}.")]:
                    values[part] = 0.0
            elif name not in values and joint.nq == 1:  # one that its limits, or what it follows, leave no way
                q[joint.idx_q] = _still(robot, name, float(model.lowerPositionLimit[joint.idx_q]))
        pinocchio.framesForwardKinematics(model, data, q)
        frames = joint_frames(module, IDENTITY, [values[name] for name in names])
        for effector in module.effectors:
            ours = compose(frames[effector.joint], effector.placement)
            frame = model.getFrameId(links[int(effector.name[1:])], pinocchio.FrameType.BODY)
            theirs = pinocchio.SE3ToXYZQUAT(data.oMf[frame])
            if _off(ours, tuple(theirs.tolist())) > CLOSE:
                return False
    return True


def _as_mujoco(file: Path, urdfs: list[str]) -> bool:
    """Whether each body of the modules lies, from the first body of its module, as MuJoCo has it."""
    import mujoco
    import numpy as np
    import pinocchio

    model = mujoco.MjModel.from_xml_path(str(file))
    data, draw = mujoco.MjData(model), Random(1)
    names = [mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_JOINT, k) for k in range(model.njnt)]
    values = {}
    for k, name in enumerate(names):
        if model.jnt_type[k] in (2, 3) and name:
            values[name] = data.qpos[model.jnt_qposadr[k]] = draw.uniform(-1, 1)
    mujoco.mj_kinematics(model, data)
    for text in urdfs:
        robot = pinocchio.buildModelFromXML(text.replace("<mimic", "<ignored"))
        other, q = robot.createData(), pinocchio.neutral(robot)
        for name, joint in zip(robot.names, robot.joints, strict=True):
            value = values.get(name)
            if value is not None:
                turned = [value] if joint.nq == 1 else [math.cos(value), math.sin(value)]
                q[joint.idx_q : joint.idx_q + joint.nq] = turned
        pinocchio.framesForwardKinematics(robot, other, q)
        first = None
        for frame, place in zip(robot.frames, other.oMf, strict=True):
            body = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, frame.name)
            if body <= 0 or frame.type != pinocchio.FrameType.BODY:  # a joint may be called as a body is
                continue
            w, x, y, z = data.xquat[body].tolist()
            pair = tuple(pinocchio.SE3ToXYZQUAT(place).tolist()), (*np.array(data.xpos[body]).tolist(), x, y, z, w)
            first = first or pair
            if _off(*(compose(inverse(first[k]), pair[k]) for k in (0, 1))) > CLOSE:
                return False
    return True


def _off(one: tuple[float, ...], other: tuple[float, ...]) -> float:
    sign = math.copysign(1.0, sum(a * b for a, b in zip(one[3:], other[3:], strict=True)))
    scale = max(1.0, *(abs(v) for v in one[:3]))
    away = [abs(a - b) / scale for a, b in zip(one[:3], other[:3], strict=True)]
    return max(*away, *(abs(a - sign * b) for a, b in zip(one[3:], other[3:], strict=True)))


if __name__ == "__main__":
    main()
