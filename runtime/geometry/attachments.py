"""What can move in a phase, and which modules form one robot, read off the motion literals that hold."""

from __future__ import annotations

from collections.abc import Mapping

from ...compiler.ir import Fact, ModuleType, Problem
from ...compiler.kept_pairs import keeps_pose, kept_pairs
from ...compiler.motion.bolted import bolted
from ...compiler.remembering import remembered
from ..skeleton import Skeleton
from .drives import braked


def carrier(problem: Problem, name: str) -> str:
    """The module or body whose slot holds object `name`: the module of an effector, else the object itself."""
    found = problem.world.effector(name)
    return found[0].name if found else name


def _keeps(problem: Problem, literal: Fact) -> bool:
    return any(row.when == "keep" for row in problem.motions[literal[0]].rows)


@remembered(8)
def followers(problem: Problem, mode: frozenset[Fact]) -> frozenset[str]:
    """The bodies that move while `mode` holds: those that follow an effector, directly or through other bodies."""
    world = problem.world
    pairs: list[tuple[str, str]] = []
    for literal in mode:
        kept = keeps_pose(problem, literal)
        if kept:
            pairs.append(kept)
        elif _keeps(problem, literal):
            pairs.extend((a, b) for a in literal[1:] for b in literal[1:] if a != b)
    found: set[str] = set()
    grew = True
    while grew:
        grew = False
        for leader, follower in pairs:
            movable = follower in world.bodies and world.bodies[follower].movable
            if movable and follower not in found and (world.owner(leader) in world.modules or leader in found):
                found.add(follower)
                grew = True
    return frozenset(found)


@remembered(8)
def robots(problem: Problem, mode: frozenset[Fact]) -> Mapping[str, str]:
    """Module name to the first module, by name, of the robot that it is part of while `mode` holds: modules are one
    robot when a relation that is kept links them, directly or through a body that follows them."""
    facts = sorted(mode)
    carried = followers(problem, mode)
    parent = {name: name for name in problem.world.modules} | {name: name for name in carried}

    def root(name: str) -> str:
        while parent[name] != name:
            name = parent[name]
        return name

    for literal in facts:
        if not _keeps(problem, literal):
            continue
        members = sorted({carrier(problem, a) for a in literal[1:]} & parent.keys())
        for other in members[1:]:
            a, b = sorted((root(members[0]), root(other)))
            parent[b] = a
    groups: dict[str, str] = {}
    for name in sorted(problem.world.modules):
        groups.setdefault(root(name), name)
    return {name: groups[root(name)] for name in problem.world.modules}


POSE = frozenset(range(7))
"""The entries of a module's slot that are the pose of its frame."""


@remembered(8)
def standing(problem: Problem, mode: frozenset[Fact]) -> frozenset[str]:
    """The modules whose frames stay where they are while `mode` holds: those that are bolted, and of each robot that
    nothing holds to what rests its first one by name, as what stands on nothing moves only against itself."""
    world, carried, robot = problem.world, followers(problem, mode), robots(problem, mode)
    fixed = bolted(problem, mode)
    held = {robot[name] for name in fixed}
    for pair in kept_pairs(problem, mode):
        for own, other in (pair, pair[::-1]):
            if carrier(problem, own) in robot and other in world.bodies and other not in carried:
                held.add(robot[carrier(problem, own)])
    return fixed | (frozenset(robot.values()) - held)


@remembered(8)
def still_entries(problem: Problem, mode: frozenset[Fact]) -> Mapping[str, frozenset[int]]:
    """By module, the entries of its slot `(7 + n,)` that keep their values while `mode` holds: the pose of what stands
    still, and joints that brakes hold."""
    found = {name: frozenset(7 + i for i in joints) for name, joints in braked(problem, mode).items()}
    return found | {name: POSE | found.get(name, frozenset()) for name in standing(problem, mode)}


@remembered(8)
def looped(problem: Problem, mode: frozenset[Fact]) -> frozenset[str]:
    """The modules of robots that are fixed to what rests more than once while `mode` holds: their joints close a loop,
    in which none moves alone."""
    world, carried, robot = problem.world, followers(problem, mode), robots(problem, mode)
    anchors: dict[str, set[str]] = {}
    for name in bolted(problem, mode):
        anchors.setdefault(robot[name], set()).add(name)
    for pair in kept_pairs(problem, mode):
        for own, other in (pair, pair[::-1]):
            if carrier(problem, own) in robot and other in world.bodies and other not in carried:
                anchors.setdefault(robot[carrier(problem, own)], set()).add(own)
    return frozenset(name for name, first in robot.items() if len(anchors.get(first, ())) > 1)


@remembered(8)
def clamped(problem: Problem, mode: frozenset[Fact]) -> frozenset[str]:
    """The modules that rest while `mode` holds whatever the others do, or may as well: those without joints that can
    move which are kept to something at rest, and those of which two ends, or an end and the frame, are."""
    world = problem.world
    stiff = {name for name, m in world.modules.items() if _stiff(m.type, braked(problem, mode).get(name))}
    carried = followers(problem, mode)
    rest = set[str]()
    pairs = kept_pairs(problem, mode)
    found: set[str] = set()
    grew = True
    while grew:
        ends: dict[str, set[str]] = {name: {name} for name in bolted(problem, mode)}
        for pair in pairs:
            for own, other in (pair, pair[::-1]):
                base = carrier(problem, other)
                resting = base in rest or (base in world.bodies and base not in carried)
                if resting and carrier(problem, own) in world.modules:
                    ends.setdefault(carrier(problem, own), set()).add(own)
        held = {name for name, own in ends.items() if len(own) > 1 or name in stiff}
        grew = not held <= found
        found |= held
        rest |= held
    return frozenset(found)


def _stiff(type_: ModuleType, held: frozenset[int] | None) -> bool:
    """Whether no joint of a module can move, where those `held` cannot."""
    return len(type_.joints) == len(held or ())


def next_mode(skeleton: Skeleton, phase: int) -> frozenset[Fact]:
    """The motion literals that hold after the switch of `phase`."""
    return skeleton.phases[phase + 1].mode if phase + 1 < len(skeleton) else skeleton.final_mode


def involved(skeleton: Skeleton, phase: int) -> frozenset[str]:
    """The modules of the robots that the switch of `phase` concerns: some literal that it adds names them, or what
    they are part of. Modules that may rest meanwhile do so."""
    problem, world = skeleton.problem, skeleton.problem.world
    mode = skeleton.phases[phase].mode
    carried = followers(problem, mode)
    robot = robots(problem, mode)
    touched = {carrier(problem, a) for literal in skeleton.phases[phase].added for a in literal[1:]}
    for literal in mode:
        names = {carrier(problem, a) for a in literal[1:]}
        if touched & names & carried:
            touched |= names & problem.world.modules.keys()
    active = {robot[name] for name in touched if name in robot}
    resting = clamped(problem, mode)
    held = braked(problem, mode)
    named = {n for n in touched if n in world.modules and not _stiff(world.modules[n].type, held.get(n))}
    return frozenset(n for n, first in robot.items() if first in active and (n in named or n not in resting))
