"""Plans as tables: CSV, one line per sample, and the arrays of NumPy."""

from __future__ import annotations

import csv
import io
import zipfile

import numpy as np
from numpy.typing import NDArray

from ..plan import Plan
from .motion import Array, moved, poses, times, torques, trajectory

POSE = ("x", "y", "z", "qx", "qy", "qz", "qw")


def columns(plan: Plan, rate: float | None) -> dict[str, Array]:
    """Columns (T,) by name: `time`; `MODULE.JOINT`, `MODULE.JOINT.rate` and `MODULE.JOINT.acceleration`, where the
    plan tells it `MODULE.JOINT.torque`; and the pose of each module and moving body, `NAME/x` to `NAME/qw`. SI units;
    the frame is the world."""
    t = times(plan, rate)
    found = {"time": t}
    for module in plan.modules:
        motion, given = trajectory(plan, module.name, t), torques(plan, module.name, t)
        for k, joint in enumerate(motion.joints):
            found[f"{module.name}.{joint}"] = motion.q[:, k]
            found[f"{module.name}.{joint}.rate"] = motion.dq[:, k]
            found[f"{module.name}.{joint}.acceleration"] = motion.ddq[:, k]
            if given is not None:
                found[f"{module.name}.{joint}.torque"] = given[:, k]
    for name in [*(m.name for m in plan.modules), *moved(plan)]:
        found |= {f"{name}/{part}": column for part, column in zip(POSE, poses(plan, name, t).T, strict=True)}
    return found


def csv_table(plan: Plan, rate: float | None) -> bytes:
    """The columns with a heading, numbers as short as they can be read back exactly."""
    found, text = columns(plan, rate), io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(found)
    writer.writerows(zip(*(c.tolist() for c in found.values()), strict=True))
    return text.getvalue().encode()


def arrays(plan: Plan, rate: float | None) -> bytes:
    """`time`; of each module `NAME/q`, `NAME/dq`, `NAME/ddq` (T, joints), where told `NAME/torque`, `NAME/joints`, and
    of each module and moving body `NAME/poses` (T, 7)."""
    t = times(plan, rate)
    found: dict[str, Array | NDArray[np.str_]] = {"time": t}
    for module in plan.modules:
        motion = trajectory(plan, module.name, t)
        found |= {f"{module.name}/{n}": getattr(motion, n) for n in ("q", "dq", "ddq")}
        given = torques(plan, module.name, t)
        found |= {f"{module.name}/torque": given} if given is not None else {}
        found[f"{module.name}/joints"] = np.array(motion.joints, dtype=str)
    for name in [*(m.name for m in plan.modules), *moved(plan)]:
        found[f"{name}/poses"] = poses(plan, name, t)
    return _archive(found)


def _archive(arrays: dict[str, Array | NDArray[np.str_]]) -> bytes:
    """The file of `numpy.load`, without the time at which it was made."""
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, array in arrays.items():
            stream = io.BytesIO()
            np.lib.format.write_array(stream, np.ascontiguousarray(array), allow_pickle=False)
            archive.writestr(zipfile.ZipInfo(f"{name}.npy"), stream.getvalue())
    return content.getvalue()
