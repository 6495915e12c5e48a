"""The machine that computes, as far as seconds of computing depend on it."""

from __future__ import annotations

import os
import platform
from functools import cache
from pathlib import Path

from .plan import MachineRecord

CPU_INFO = Path("/proc/cpuinfo")


@cache
def this_machine() -> MachineRecord:
    """Nothing that names it: neither host nor user."""
    system = f"{platform.system()} {platform.release()}".strip()
    return MachineRecord(_processor(), platform.machine(), _cores(), system)


def _processor() -> str:
    """Its model where the system tells it, else "", as of most that are no PC."""
    try:
        lines = CPU_INFO.read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        return platform.processor()
    models = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(models, "")


def _cores() -> int:
    """Those that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
