"""Actions in lifted form: names replaced in the order of their first appearance."""

from __future__ import annotations

from collections.abc import Sequence

from ....compiler.ir import Action, Chain, Problem
from ....compiler.symbolic.symmetry import is_reversible

Signature = tuple[object, ...]


class Names(dict[str, object]):
    """What stands for an object, in the order of appearance, and how many of a kind were met."""

    def __init__(self) -> None:
        super().__init__()
        self.counts: dict[str, int] = {}

    def next(self, kind: str) -> int:
        self.counts[kind] = self.counts.get(kind, 0) + 1
        return self.counts[kind]


class Lifting:
    """Replaces modules, and ends of reversible ones, by numbers in the order of appearance."""

    def __init__(self, problem: Problem) -> None:
        self.modules = problem.world.modules
        self.reversible = {m.name for m in self.modules.values() if is_reversible(m.type)}

    def actions(self, actions: Sequence[Action]) -> tuple[Signature, Names]:
        names = Names()
        return tuple((a.rule, *(self.token(arg, names) for arg in a.args)) for a in actions), names

    def token(self, arg: object, names: Names) -> object:
        """What stands for an argument of an action."""
        if isinstance(arg, Chain):
            return ("chain", *(self.token(part, names) for line in arg.modules for part in line))
        if not isinstance(arg, str) or arg in names:
            return names[arg] if isinstance(arg, str) else arg
        module, dot, end = arg.rpartition(".")
        if arg in self.modules:
            kind = self.modules[arg].type.name
            names[arg] = (kind, names.next(kind))
        elif dot and module in self.modules:
            whole = self.token(module, names)
            names[arg] = (whole, names.next(module) if module in self.reversible else end)
        else:
            return arg
        return names[arg]


def objects_of(action: Action) -> list[str]:
    """The objects that an action names, in order."""
    found: list[str] = []
    for arg in action.args:
        if isinstance(arg, Chain):
            found += [part for line in arg.modules for part in line]
        elif isinstance(arg, str):
            found.append(arg)
    return found
