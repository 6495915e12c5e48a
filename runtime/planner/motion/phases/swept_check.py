"""The swept check: whether a path keeps clear all along the spline that is stored of it, and within limits and, where
it gives way to loads, strengths."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ....skeleton import Array
from .phase_batch import Batch
from .settings import PHASES
from .swept_clearance import swept_clearance


@dataclass(slots=True)
class Sweep:
    """The swept check per phase: excess clearance (metres; accepted from 0), how far joint limits are exceeded
    (up to `PHASES.beyond`), how far the largest step between slices exceeds what is allowed (up to 0), and whether all
    strengths are kept."""

    clearance: Array
    limit: Array
    step: Array
    borne: NDArray[np.bool_]

    @property
    def clean(self) -> NDArray[np.bool_]:
        return (self.clearance >= 0.0) & (self.limit <= PHASES.beyond) & (self.step <= 0.0) & self.borne


def sweep(batch: Batch, paths: Array, chunk: int = 16) -> Sweep:
    """Check paths `(phases, slices + 1, joints)` on the splines of their eased motions."""
    values = batch.stored @ paths
    joints = batch.joints
    beyond = np.maximum(values - joints.upper[:, None], joints.lower[:, None] - values)
    step = np.abs(np.diff(paths, axis=1)) - joints.step[:, None]
    clearance = np.concatenate([
        swept_clearance(batch.exact.take(index), values[index])
        for index in (np.arange(k, min(k + chunk, len(batch))) for k in range(0, len(batch), chunk))
    ])
    borne = np.ones(len(batch), bool)
    for k, loads in enumerate(batch.loads):
        borne[k] = loads.borne(values[k, :: PHASES.load_stride])
    return Sweep(clearance, beyond.max(axis=(1, 2), initial=-np.inf), step.max(axis=(1, 2), initial=-np.inf), borne)
