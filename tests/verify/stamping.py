"""Plan files whose motion is drawn anew with other time stamps."""

from __future__ import annotations

from collections.abc import Callable

import msgspec
import numpy as np
from scipy.spatial.transform import Rotation

from tamplang.compiler.pipeline import compile_sources
from tamplang.langs.source import Source
from tamplang.runtime.plan import Plan
from tamplang.runtime.verify.findings import Findings
from tamplang.runtime.verify.geometry import Array, Frames
from tamplang.runtime.verify.happenings import happenings_of
from tamplang.runtime.verify.kinematics import Kinematics, motion_of
from tamplang.runtime.verify.links import links_of
from tamplang.runtime.verify.replay import replay
from tamplang.runtime.verify.sampler import Sampler, curves_of

Stamps = Callable[[float, float], Array]
"""Time stamps of a phase from its start to its end, both among them."""


def sampler_of(plan: Plan) -> Sampler:
    sources = [Source(s.path, s.text) for s in plan.task.sources]
    problem, _ = compile_sources(sources, plan.task.name, {}, plan.task.seed)
    kinematics = {m.name: Kinematics(m) for m in plan.modules}
    motion, story = motion_of(plan, kinematics), replay(problem, plan, Findings())
    happenings = happenings_of(problem, plan, story.modes)
    links = links_of(problem, story.modes, motion, happenings, 1e-6)
    return Sampler(problem.world, motion, kinematics, happenings, links, curves_of(plan))


def poses(frames: Frames, count: int) -> list[list[float]]:
    spread = frames.spread(count)
    return np.hstack([spread.position, Rotation.from_matrix(spread.rotation).as_quat()]).tolist()


def stamped(plan: Plan, stamps: list[Stamps] | Stamps) -> Plan:
    """A drawing of the same motion with other time stamps, phase by phase: every sample lies on the motion."""
    sampler, data = sampler_of(plan), msgspec.to_builtins(plan)
    times: list[float] = []
    tracks: dict[str, list[list[float]]] = {t.name: [] for t in plan.tracks}
    joints: dict[str, list[list[float]]] = {t.name: [] for t in plan.tracks}
    bodies: dict[str, list[list[float]]] = {t.name: [] for t in plan.body_tracks}
    for phase, record in enumerate(plan.phases):
        at = (stamps[phase] if isinstance(stamps, list) else stamps)(record.start, record.end)
        times += at.tolist()
        placement = sampler.at(phase, at)
        for name, rows in [*tracks.items(), *bodies.items()]:
            rows += poses(placement.frame(name), len(at))
        for name, rows in joints.items():
            rows += np.broadcast_to(sampler._joints(name, phase, at), (len(at), len(plan.modules[0].joints))).tolist()
    data["times"] = times
    data["tracks"] = [{"name": n, "poses": tracks[n], "joints": joints[n]} for n in tracks]
    data["body_tracks"] = [{"name": n, "first": 0, "poses": rows} for n, rows in bodies.items()]
    return msgspec.convert(data, Plan)


def even(count: int) -> Stamps:
    return lambda start, end: np.linspace(start, end, count)


def uneven(start: float, end: float) -> Array:
    share = np.linspace(0.0, 1.0, 40) ** 3
    return start + (end - start) * share


def crowded(start: float, end: float) -> Array:
    """All but the last stamp in the first hundredth of the phase."""
    return np.append(np.linspace(start, start + 0.01 * (end - start), 60), end)


def random_stamps(start: float, end: float) -> Array:
    inner = np.random.default_rng(7).uniform(start, end, 50)
    return np.unique(np.concatenate([[start], inner, [end]]))


HIDING: dict[str, Stamps] = {
    "two": even(2),
    "crowded": crowded,
    "crowded at both ends": lambda start, end: np.concatenate([
        start + np.linspace(0.0, 0.01, 5_000), end - np.linspace(0.01, 0.0, 5_000)
    ]),
    "crowded in the middle": lambda start, end: np.unique(np.concatenate([
        [start], 0.5 * (start + end) + np.linspace(-0.01, 0.01, 50), [end]
    ])),
}  # fmt: skip
