"""What motion has refused, in the search's terms: sequences of actions that must not be done one after the other.

A conflict is stored lifted: modules of one type stand for each other, and so do the ends of a module that is the same
from both. Names are replaced in the order of their first appearance, which makes the lifted form of a prefix the
prefix of the lifted form; so one automaton watches for all conflicts. All no-goods are soft: a local solver's refusal
is no proof.
"""

from __future__ import annotations

from collections.abc import Sequence

from ..compiler.ir import Action, Chain, Problem
from ..compiler.successors import Successors
from ..compiler.symmetry import is_reversible

Signature = tuple[object, ...]
History = tuple[int, ...]
"""The last actions, as far as they begin some conflict."""
OFF = -1
"""Place in the tree of forbidden prefixes once a plan has left it."""
LEAF = -2


class NoGoods:
    """Forbidden actions, sequences and prefixes of one search."""

    def __init__(self, problem: Problem, successors: Successors) -> None:
        self.problem = problem
        self.successors = successors
        self.reversible = {m.name for m in problem.world.modules.values() if is_reversible(m.type)}
        self._conflicts: set[Signature] = set()
        self._beginnings: set[Signature] = set()
        self._single: dict[int, bool] = {}
        self._moves: dict[tuple[History, int], History | None] = {}
        self._tree: list[dict[int, int]] = [{}]

    @property
    def active(self) -> bool:
        """Whether some sequence is forbidden."""
        return bool(self._conflicts)

    @property
    def watches(self) -> bool:
        """Whether some conflict is longer than one action."""
        return bool(self._beginnings)

    @property
    def root(self) -> int:
        """Where a plan starts in the tree of prefixes."""
        return 0 if self._tree[0] else OFF

    def forbid_sequence(self, actions: Sequence[Action]) -> None:
        """Forbid these actions one after the other, anywhere, and whatever is the same but for names."""
        signature = self.signature(actions)
        self._conflicts.add(signature)
        self._beginnings.update(self.signature(actions[:k]) for k in range(1, len(actions)))
        self._single.clear()
        self._moves.clear()

    def forbid_prefix(self, numbers: Sequence[int]) -> None:
        """Forbid exactly these actions from the start."""
        node = 0
        for number in numbers[:-1]:
            following = self._tree[node].get(number)
            if following == LEAF:
                return
            if following is None:
                self._tree.append({})
                following = self._tree[node][number] = len(self._tree) - 1
            node = following
        if numbers:
            self._tree[node][numbers[-1]] = LEAF

    def readmit(self) -> bool:
        """Forget the sequences, for a second try; exact prefixes stay. False when there were none."""
        known = bool(self._conflicts)
        self._conflicts.clear()
        self._beginnings.clear()
        self._single.clear()
        self._moves.clear()
        return known

    def allows(self, number: int) -> bool:
        """Whether an action is not forbidden by itself."""
        known = self._single.get(number)
        if known is None:
            signature = self.signature([self.successors.action(number)])
            known = self._single[number] = signature not in self._conflicts
        return known

    def follow(self, history: History, number: int) -> History | None:
        """The history after one more action; None when that completes a conflict."""
        key = (history, number)
        if key not in self._moves:
            self._moves[key] = self._follow((*history, number))
        return self._moves[key]

    def descend(self, node: int, number: int) -> int:
        """The place in the tree of prefixes after an action: LEAF where it is forbidden, OFF outside."""
        return self._tree[node].get(number, OFF) if node >= 0 else OFF

    def _follow(self, history: History) -> History | None:
        actions = [self.successors.action(n) for n in history]
        signatures = [self.signature(actions[k:]) for k in range(len(actions))]
        if any(s in self._conflicts for s in signatures):
            return None
        for k, signature in enumerate(signatures):
            if signature in self._beginnings:
                return history[k:]
        return ()

    def signature(self, actions: Sequence[Action]) -> Signature:
        """The actions with modules, and ends of reversible ones, numbered in the order of appearance."""
        names: dict[str, object] = {}
        counts: dict[str, int] = {}
        return tuple((a.rule, *(self._token(arg, names, counts) for arg in a.args)) for a in actions)

    def _token(self, arg: object, names: dict[str, object], counts: dict[str, int]) -> object:
        if isinstance(arg, Chain):
            parts = (self._token(part, names, counts) for line in arg.modules for part in line)
            return ("chain", *parts)
        if not isinstance(arg, str):
            return arg
        if arg in names:
            return names[arg]
        modules = self.problem.world.modules
        module, dot, end = arg.rpartition(".")
        if arg in modules:
            kind = modules[arg].type.name
            counts[kind] = counts.get(kind, 0) + 1
            names[arg] = (kind, counts[kind])
        elif dot and module in modules:
            whole = self._token(module, names, counts)
            if module in self.reversible:
                counts[module] = counts.get(module, 0) + 1
                names[arg] = (whole, counts[module])
            else:
                names[arg] = (whole, end)
        else:
            return arg
        return names[arg]
