"""Under which conditions a plan is carried out, and a window to watch it."""

from __future__ import annotations

import os
import time
from dataclasses import dataclass
from typing import Any

from .model import STEP, EngineWorld

FRAMES = 30
"""Pictures a second."""


class NoDisplay(Exception):
    """There is no display to show the simulation on."""


@dataclass(frozen=True, slots=True)
class Conditions:
    """`noise` is the deviation of the random factors, by `seed`, of weights, drives and friction; with `contact` feet
    and things stand by friction and adhesion; `view` shows it live."""

    noise: float = 0.0
    seed: int = 0
    contact: bool = False
    view: bool = False


class Watch:
    """A window in which the engine's world is seen as it moves. Raises NoDisplay."""

    def __init__(self, world: EngineWorld) -> None:
        if not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
            raise NoDisplay("neither DISPLAY nor WAYLAND_DISPLAY is set")
        try:
            from importlib import import_module

            viewer: Any = import_module("mujoco.viewer")
            self._window: Any = viewer.launch_passive(world.model, world.data)
        except Exception as error:
            raise NoDisplay(str(error) or type(error).__name__) from None
        self._steps, self._begun = 0, time.monotonic()

    def show(self) -> None:
        """One step further; pictures come at the speed of real time at most."""
        self._steps += 1
        if self._steps % round(1.0 / (FRAMES * STEP)) == 0:
            self._window.sync()
            time.sleep(max(0.0, self._begun + self._steps * STEP - time.monotonic()))
