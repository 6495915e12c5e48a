"""Whether a plan's parts fit together at all: sizes, finite numbers, unit quaternions, times. Everything else
relies on it, so a plan that fails here is not measured further."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import field
from itertools import chain

import numpy as np

from ...compiler.ir import JointKind, ShapeKind
from ...langs.frozen import dataclass
from ..plan import (
    COUPLINGS,
    FORMAT,
    KNOWN_NEEDS,
    PARTS,
    PASSIVE,
    PLACES,
    STATICS,
    BodyRecord,
    CouplingRecord,
    ModuleRecord,
    Plan,
    ShapeRecord,
    SplineRecord,
)
from .findings import Findings
from .geometry import Array
from .limits import LIMITS
from .shapes import SIZES, is_solid
from .told_forces import told

LARGEST = 1e10
"""Numbers beyond it, infinities and NaN count as not finite."""
MOST_FRAMES = 5_000_000
"""Samples times moving frames of a plan, at most: half a gigabyte of memory, several times what a large plan needs."""
MOST_KNOTS = 10_000
"""Knots of one spline, at most: a hundred times as many as planned ones have."""
NEAREST_KNOTS = 1e-6
"""Seconds from one knot to the next, at least; time stamps have 10 decimals. Planned ones are some 10 ms apart."""

Rows = Sequence[Sequence[float]]


@dataclass(frozen=True, slots=True)
class Samples:
    """The tracks of a plan as arrays: `poses` `(T, 7)` of modules and of bodies that have one, `joints` `(T, n)`."""

    poses: dict[str, Array] = field(default_factory=dict)
    joints: dict[str, Array] = field(default_factory=dict)


def samples_of(plan: Plan) -> Samples:
    """The samples of a plan that is well formed."""
    widths = {m.name: len(m.joints) for m in plan.modules}
    poses = {t.name: _table(t.poses, 7) for t in plan.tracks}
    pieces = [_table(piece.poses, 7) for piece in plan.body_tracks]
    joints = {t.name: _table(t.joints, widths[t.name]) for t in plan.tracks}
    return Samples(poses | _whole_body_tracks(plan, pieces), joints)


def check_structure(plan: Plan, findings: Findings) -> Samples | None:
    """The samples of a plan that is well formed; else None, and what is not is in the findings, with the part's
    name."""
    before = len(findings.failures)
    samples = Samples()
    if plan.format != FORMAT:
        findings.fail("structure", f"the plan has format {plan.format!r}, not {FORMAT!r}")
    for need in plan.needs:
        if need not in KNOWN_NEEDS:
            findings.fail("structure", f"the plan needs {need}, which is not known")
    joints = [j for m in plan.modules for j in m.joints]
    ends = [e.shape for m in plan.modules for e in m.effectors if e.shape is not None]
    for need, has in ((COUPLINGS, any(j.follows for j in joints)), (PASSIVE, any(j.passive for j in joints)),
                      (PLACES, not all(b.collides for b in plan.bodies)),
                      (PARTS, any(s.parts for s in (*ends, *(b.shape for b in plan.bodies)))),
                      (STATICS, told(plan) is not None)):  # fmt: skip
        if has and need not in plan.needs:
            findings.fail("structure", f"the plan has {need}, but does not say that it needs that")
    frames = sum(1 + len(m.joints) + len(m.effectors) for m in plan.modules) + len({t.name for t in plan.body_tracks})
    if len(plan.times) * frames > MOST_FRAMES:
        message = f"{len(plan.times)} samples of {frames} frames that move: more than {MOST_FRAMES} are not looked at"
        findings.fail("structure", message)
        return None
    _check_times(plan, findings)
    for name in _repeated([m.name for m in plan.modules] + [b.name for b in plan.bodies]):
        findings.fail("structure", f"{name} occurs twice", between=[name])
    for module in plan.modules:
        _check_module(module, findings)
    _check_bodies(plan.bodies, findings)
    _check_tracks(plan, samples, findings)
    if len(findings.failures) == before:
        _check_splines(plan, findings)
    return samples if len(findings.failures) == before else None


def _repeated(names: Sequence[str]) -> list[str]:
    return sorted(name for name, count in Counter(names).items() if count > 1)


def _numbers(rows: Rows, width: int) -> bool:
    return set(map(len, rows)) <= {width} and _finite(_table(rows, width))


def _table(rows: Rows, width: int) -> Array:
    """Rows of one length as an array `(n, width)`."""
    return np.fromiter(chain.from_iterable(rows), float, len(rows) * width).reshape(len(rows), width)


def _finite(values: Array) -> bool:
    return bool((np.abs(values) <= LARGEST).all())


# --- times -------------------------------------------------------------------------------------------------------


def _check_times(plan: Plan, findings: Findings) -> None:
    if not plan.times or not _numbers([plan.times], len(plan.times)):
        findings.fail("times", "the time stamps are missing or not finite")
        return
    steps = np.diff(plan.times)
    if plan.times[0] != 0.0:
        findings.fail("times", f"time starts at {plan.times[0]} s, not at 0", amount=plan.times[0], unit="s")
    if np.any(steps < 0):
        at = int(np.argmin(steps))
        findings.fail("times", "time runs backwards", amount=float(-steps[at]), unit="s", time=plan.times[at])
        return
    bounds = [t for p in plan.phases for t in (p.start, p.end)]
    if not _numbers([bounds], len(bounds)):
        findings.fail("times", "the start or end of a phase is not finite")
        return
    found = phase_ranges(plan.times)
    if len(found) != max(1, len(plan.phases)):
        message = f"{len(plan.phases)} phases, but the time stamps of {len(found)}"
        findings.fail("times", message, amount=float(abs(len(found) - len(plan.phases))))
        return
    for index, (phase, (first, last)) in enumerate(zip(plan.phases, found, strict=False)):
        for stored, sampled in ((phase.start, plan.times[first]), (phase.end, plan.times[last])):
            message = f"phase {index + 1} says {stored} s, its samples {sampled} s"
            findings.measure("time_s", abs(stored - sampled), message, time=sampled)
        if last == first:
            findings.fail("times", f"phase {index + 1} has a single sample", time=phase.start)


def phase_ranges(times: Sequence[float]) -> list[tuple[int, int]]:
    """First and last sample of every phase: a time stamp that occurs twice ends one and starts the next."""
    breaks = [i for i in range(len(times) - 1) if times[i + 1] == times[i]]
    return list(zip([0, *(i + 1 for i in breaks)], [*breaks, len(times) - 1], strict=True))


# --- records -----------------------------------------------------------------------------------------------------


def _check_shape(shape: ShapeRecord, owner: str, findings: Findings) -> None:
    good = _numbers([shape.size], len(shape.size))
    if shape.kind == ShapeKind.CONVEX:
        good = good and len(shape.size) % 3 == 0 and is_solid(shape.size)
    else:
        good = good and SIZES.get(shape.kind) == len(shape.size) and min(shape.size) > 0
    if not good:
        message = f"{owner} has a {shape.kind} of size {shape.size}"
        findings.fail("structure", message, between=[owner])
    for part in shape.parts:
        if not _numbers([part.at], 3) or part.shape.parts:
            findings.fail("structure", f"{owner} has a part that is none", between=[owner])
        else:
            _check_shape(part.shape, owner, findings)


def _check_poses(poses: Rows, count: int, what: str, owner: str, findings: Findings) -> Array | None:
    """The poses as an array `(count, 7)`; None, and a finding, where they are none."""
    table = _check_table(poses, count, 7, what, "seven", owner, findings)
    if table is not None and count:
        off = np.abs(np.linalg.norm(table[:, 3:], axis=1) - 1)
        worst = int(np.argmax(off))
        findings.measure("quaternion", float(off[worst]), f"{what}: no unit quaternion", between=[owner])
    return table


def _check_table(
    rows: Rows, count: int, width: int, what: str, wide: str, owner: str, findings: Findings
) -> Array | None:
    if len(rows) != count:
        findings.fail("structure", f"{what}: {len(rows)} rows for {count} time stamps", between=[owner])
        return None
    table = _table(rows, width) if set(map(len, rows)) <= {width} else None
    if table is None or not _finite(table):
        findings.fail("not finite", f"{what}: a row is not {wide} finite numbers", between=[owner])
        return None
    return table


def _check_module(module: ModuleRecord, findings: Findings) -> None:
    name = module.name
    count = len(module.joints)
    _check_poses([module.pose], 1, f"pose of {name}", name, findings)
    if not _numbers([module.start], count):
        findings.fail("structure", f"{name} does not have {count} finite start values", between=[name])
    for index, joint in enumerate(module.joints):
        _check_poses([joint.placement], 1, f"placement of {name} {joint.name}", name, findings)
        numbers = [*joint.axis, joint.lower, joint.upper, joint.speed, joint.acceleration, joint.jerk]
        good = _numbers([numbers], 8) and any(joint.axis) and joint.kind in (JointKind.REVOLUTE, JointKind.PRISMATIC)
        good = good and min(joint.speed, joint.acceleration, joint.jerk) > 0
        if not good or not -1 <= joint.parent < index or joint.lower > joint.upper:
            findings.fail("structure", f"{name} has a joint {joint.name} that makes no sense", between=[name])
        if joint.follows is not None and not _couples(module, index, joint.follows):
            message = f"{name} has a joint {joint.name} that follows what cannot lead it"
            findings.fail("structure", message, between=[name])
    for effector in module.effectors:
        where = f"{name}.{effector.name}"
        _check_part(effector.joint, effector.placement, effector.shape, where, count, findings)
    for number, link in enumerate(module.links):
        _check_part(link.joint, link.placement, link.shape, f"{name} link {number + 1}", count, findings)


def _couples(module: ModuleRecord, index: int, coupling: CouplingRecord) -> bool:
    """Whether a joint can follow another one: that has a drive where it has one, and follows none itself."""
    if not 0 <= coupling.leader < len(module.joints) or not _finite(np.array([coupling.factor, coupling.offset])):
        return False
    leader = module.joints[coupling.leader]
    same = leader.passive == module.joints[index].passive
    return leader.follows is None and same and coupling.factor != 0


def _check_part(
    joint: int, placement: list[float], shape: ShapeRecord | None, where: str, count: int, findings: Findings
) -> None:
    _check_poses([placement], 1, f"placement of {where}", where, findings)
    if not -1 <= joint < count:
        findings.fail("structure", f"{where} is fixed to joint {joint} of {count}", between=[where])
    if shape is not None:
        _check_shape(shape, where, findings)


def _check_bodies(bodies: Sequence[BodyRecord], findings: Findings) -> None:
    """Shapes that are alike, and poses all at once: there may be many, most of which are in order."""
    sound: set[tuple[str, tuple[float, ...]]] = set()
    for body in bodies:
        shape = body.shape.kind, tuple(body.shape.size)
        if body.shape.parts or shape not in sound:
            before = len(findings.failures)
            _check_shape(body.shape, body.name, findings)
            sound |= {shape} if len(findings.failures) == before else set()
    for body in _doubtful(bodies):
        _check_poses([body.pose], 1, f"pose of {body.name}", body.name, findings)


def _doubtful(bodies: Sequence[BodyRecord]) -> Sequence[BodyRecord]:
    """Those whose pose may be wrong, and of the others that whose quaternion is the least unit one."""
    rows = [body.pose for body in bodies]
    if not rows or not set(map(len, rows)) <= {7}:
        return bodies
    table = _table(rows, 7)
    off = np.abs(np.linalg.norm(table[:, 3:], axis=1) - 1)
    wrong = ~((np.abs(table) <= LARGEST).all(axis=1) & (off <= LIMITS["quaternion"]))
    return [bodies[k] for k in sorted({*np.flatnonzero(wrong).tolist(), int(np.argmax(np.where(wrong, -1.0, off)))})]


# --- tracks ------------------------------------------------------------------------------------------------------


def _check_tracks(plan: Plan, samples: Samples, findings: Findings) -> None:
    """Fill in the samples of all tracks that are well formed."""
    modules = {m.name: m for m in plan.modules}
    tracks = [t.name for t in plan.tracks]
    if sorted(tracks) != sorted(modules):
        findings.fail("structure", f"tracks of {sorted(tracks)} for modules {sorted(modules)}")
    count = len(plan.times)
    for track in plan.tracks:
        table = _check_poses(track.poses, count, f"track of {track.name}", track.name, findings)
        if table is not None:
            samples.poses[track.name] = table
    _check_body_tracks(plan, samples, findings)
    for track in plan.tracks:
        if track.name in modules:
            name, width = track.name, len(modules[track.name].joints)
            table = _check_table(track.joints, count, width, f"joints of {name}", str(width), name, findings)
            if table is not None:
                samples.joints[name] = table


def _check_body_tracks(plan: Plan, samples: Samples, findings: Findings) -> None:
    """Pieces of bodies, each from the first sample of a phase to the last one of a phase, none inside another."""
    if any(f.kind == "times" for f in findings.failures):
        return
    ranges = phase_ranges(plan.times)
    starts, ends = {first for first, _ in ranges}, {last for _, last in ranges}
    bodies, ended, tables = {b.name for b in plan.bodies if len(b.pose) == 7}, dict[str, int](), []
    before = len(findings.failures)
    for piece in plan.body_tracks:
        name, last = piece.name, piece.first + len(piece.poses) - 1
        if name not in bodies:
            findings.fail("structure", f"a track of {name}, which is no body with a pose", between=[name])
        elif not (piece.first in starts and last in ends and last > piece.first > ended.get(name, -1)):
            message = f"a track of {name} does not begin and end with phases, after the one before it"
            findings.fail("structure", message, between=[name])
        table = _check_poses(piece.poses, len(piece.poses), f"track of {name}", name, findings)
        tables += [table] if table is not None else []
        ended[name] = last
    if len(findings.failures) == before:
        samples.poses.update(_whole_body_tracks(plan, tables))


def _whole_body_tracks(plan: Plan, pieces: Sequence[Array]) -> dict[str, Array]:
    """The poses `(T, 7)` of every body that ever moves: between its `pieces` it stays where it is."""
    rests = {b.name: np.asarray(b.pose, dtype=float) for b in plan.bodies}
    whole: dict[str, Array] = {}
    for piece, rows in zip(plan.body_tracks, pieces, strict=True):
        table = whole.setdefault(piece.name, np.tile(rests[piece.name], (len(plan.times), 1)))
        table[piece.first : piece.first + len(rows)] = rows
        table[piece.first + len(rows) :] = rows[-1]
    return whole


def _check_splines(plan: Plan, findings: Findings) -> None:
    """At most one spline per module and phase, with equidistant knots from the start of its first to the end of its
    last phase."""
    widths = {m.name: len(m.joints) for m in plan.modules}
    taken: set[tuple[str, int]] = set()
    for spline in plan.splines:
        name = f"spline of {spline.module} from phase {spline.first + 1}"
        if spline.module not in widths or not 0 <= spline.first <= spline.until < len(plan.phases):
            findings.fail("structure", f"{name} is of no module, or of no phase", between=[spline.module])
            continue
        phases = {(spline.module, k) for k in range(spline.first, spline.until + 1)}
        if taken & phases:
            findings.fail("structure", f"{name}: the module has another one then", between=[spline.module])
        taken |= phases
        _check_spline(plan, spline, widths[spline.module], name, findings)


def _check_spline(plan: Plan, spline: SplineRecord, width: int, name: str, findings: Findings) -> None:
    count = len(spline.knots)
    good = count >= 2 and len(spline.values) == count and _numbers([spline.knots], count)
    if not good or not _numbers(spline.values, width):
        findings.fail("structure", f"{name} is incomplete or not finite", between=[spline.module])
        return
    start, end = plan.phases[spline.first].start, plan.phases[spline.until].end
    if count > MOST_KNOTS or end - start < (count - 1) * NEAREST_KNOTS:
        message = f"{name} has {count} knots in {end - start:g} s: more than {MOST_KNOTS}, or nearer than 1 µs"
        findings.fail("structure", message, time=start, between=[spline.module])
        return
    if np.max(np.abs(np.linspace(start, end, count) - spline.knots)) > 10 * LIMITS["time_s"]:
        findings.fail("times", f"{name}: the knots do not divide its time evenly", time=start)
