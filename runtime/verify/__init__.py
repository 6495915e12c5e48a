"""The independent checker: believes nothing that a plan says about itself.

It shares no code with solver, search or constraint builder; of the compiler it uses the way from sources to IR.

    replay.py      carries out every action by the rules' text
    provenance.py  what the plan is of: hashes, sources, goal, windows, and a task of the reader's
    scene.py       modules, bodies and what happens by itself against those of the task, compiled from the sources
    structure.py   sizes, finite numbers, unit quaternions, time stamps
    kinematics.py  forward kinematics of every sample, repeated by Pinocchio at some
    constraints.py motion predicates at switches, during intervals, and what they keep constant
    motion.py      start, continuity, splines, joint limits, rest
    rates.py       speeds and accelerations of joints
    collision.py   penetration along the swept motion, by coal; sweeps.py: which pairs need no look, and when
    limits.py      the table of limits
"""

from __future__ import annotations

from .check import check, verify

__all__ = ["check", "verify"]
