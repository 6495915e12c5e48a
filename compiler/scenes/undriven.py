"""Modules that move only when something moves them, though no word says so: drawers and doors as first written.

A module whose joints state neither a drive (`speed`, `acceleration`, `jerk`, `torque`, …) nor `passive` counts as one
with drives, unless the rules say that it is none: some rule wants its own parts to be at places to each other, as a
drawer that is to be open, and no rule has it do anything to another thing. Being carried by the end of another module
is nothing that it does.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence

from ...langs import syntax
from .. import ir
from ..checks.findings import Findings
from ..checks.relaxation import Relaxation, followers

Added = tuple[tuple[int, ...], list[set[str]]]
"""Of a literal that is added the places whose objects it has follow another, and what its arguments can be."""


def without_drives(
    findings: Findings,
    declared: Mapping[str, syntax.ModuleDecl],
    robots: Mapping[str, str],
    modules: Mapping[str, ir.Module],
    relaxation: Relaxation,
    motions: Mapping[str, ir.MotionPredicate],
) -> dict[str, ir.Module]:
    """The modules, those with `passive` joints that are taken to have no drives; warns of each kind of them. `robots`
    names what each module is declared as."""
    silent = {m.name for m in modules.values() if m.type.joints and _says_nothing(declared[robots[m.name]])}
    made = dict(modules)
    if not silent:
        return made
    worked = _worked(silent, modules, relaxation, motions)
    told: set[str] = set()
    for name in sorted(worked):
        module = modules[name]
        joints = tuple(dataclasses.replace(j, passive=True) for j in module.type.joints)
        made[name] = dataclasses.replace(module, type=dataclasses.replace(module.type, joints=joints))
        if robots[name] not in told:
            told.add(robots[name])
            _tell(findings, declared[robots[name]])
    return made


def _says_nothing(module: syntax.ModuleDecl) -> bool:
    """Whether no word of a module tells of drives, or of joints without them; files of others tell of theirs."""
    joints = [item for item in module.flat() if isinstance(item, syntax.JointItem)]
    said = (bool(j.physics) or j.passive or any((j.speed, j.acceleration, j.jerk)) for j in joints)
    return module.urdf is None and not any(said)


def _worked(
    silent: set[str],
    modules: Mapping[str, ir.Module],
    relaxation: Relaxation,
    motions: Mapping[str, ir.MotionPredicate],
) -> set[str]:
    """Of the modules in question those that the rules have moved by others only."""
    own = {name: frozenset({name, *(f"{name}.{e.name}" for e in modules[name].type.effectors)}) for name in silent}
    ends = frozenset(f"{m.name}.{e.name}" for m in modules.values() for e in m.type.effectors)
    rules = [_added(motions, relaxation, relaxation.world.rules[name]) for name in relaxation.domains]
    found, before = set(silent), set[str]()
    while found != before:
        before = set(found)
        kin = frozenset().union(*(own[name] for name in found))
        for name in sorted(before):
            if any(_does(literals, own[name], kin, ends - kin) for literals in rules):
                found.discard(name)
    kin = frozenset().union(*(own[name] for name in found))
    wanted = (places for literals in rules for _, places in literals if len(places) > 1)
    moved = [places for places in wanted if all(place <= kin for place in places)]
    return {name for name in found if any(place & own[name] for places in moved for place in places)}


def _does(literals: Sequence[Added], mine: frozenset[str], kin: frozenset[str], ends: frozenset[str]) -> bool:
    """Whether a rule with these literals has a module carry something, or do anything to what is not of its `kin`
    but be carried by `ends` of others."""
    carried = False
    for following, places in literals:
        for k in following:
            others = [place for i, place in enumerate(places) if i != k]
            if not places[k] <= mine and any(place & mine for place in others):
                return True
            carried |= bool(places[k] & mine) and all(place <= ends for place in others)
    touched = (places for _, places in literals if any(place & mine for place in places))
    return not carried and any(not all(place <= kin for place in places) for places in touched)


def _added(motions: Mapping[str, ir.MotionPredicate], relaxation: Relaxation, rule: ir.Rule) -> list[Added]:
    """The motion literals that a rule adds."""
    return [
        (tuple(followers(motions[effect.literal.predicate])), relaxation.places(rule, effect.literal, loops))
        for effect, loops in ir.effects_with_loops(rule.effects)
        if effect.literal.motion and not effect.negated
    ]


def _tell(findings: Findings, module: syntax.ModuleDecl) -> None:
    findings.report(
        "W0021",
        findings.word(module.span, module.name),
        f"`{module.name}` is taken to have no drives: it states none, and the rules have it do nothing to other things",
        help="write `passive` behind its joints, or a `speed` where they have drives",
    )
