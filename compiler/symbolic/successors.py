"""Back end: successor functions on packed states, one generated Python function per flag word that is met often.

The input is any problem of the IR; nothing here knows a rule or predicate by name. A state is one int (`layout`). The
function of a flag word holds only the blocks whose conditions on the flags hold there, with all small variables and
chains bound; everything that depends on locations is a row looked up by the value of a field (`blocks`). Words that are
met a few times only go through functions of their blocks, which they share: to compile one for each would take longer.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from ...langs.trees import parts
from ..ir import Action, ChainType, Fact, Formula, Problem, Value
from .algebra import Environment
from .blocks import Block, BlockMaker
from .chains import KnownFacts
from .domains import Domains, FlatRule
from .expressions import source
from .geometry import lengths_of
from .guards import Guards
from .layout import Layout
from .normal_form import NormalForm
from .settings import SYMBOLIC
from .steps import Step

Successor = tuple[int, int]
Expander = Callable[[int], list[Successor]]
BlockExpander = Callable[[int, list[Successor]], None]


class Successors:
    """Packed states of one problem: `initial`, `expand`, `is_goal`, `facts`; actions by number."""

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        self.normal = NormalForm(problem)
        self.domains = Domains(problem, self.normal)
        self.layout = Layout(problem, self.domains)
        self.geometry = lengths_of(problem)
        self.guards = Guards(problem, self.layout, self.geometry)
        self.initial = self.layout.initial
        self._actions: list[Action] = []
        self._costs: list[float] = []
        self._ids: dict[Action, int] = {}
        self._blocks = BlockMaker(self.guards, self._action_id)
        self._expanders: dict[int, Expander] = {}
        self._calls: dict[int, int] = {}
        self._several: dict[int, Expander] = {}
        """Expanders of words that were met a few times."""
        self._by_block: dict[int, BlockExpander] = {}
        self._blocks_of: dict[int, list[Block]] = {}
        self._words: dict[int, KnownFacts] = {}
        self._goal = self.normal.normal(problem.goal, {}, False)
        self._goal_of_chains = has_chains(self._goal)
        self._goals: dict[int, Callable[[int], bool]] = {}

    def expand(self, state: int) -> list[Successor]:
        """All (successor, action number) of a state, in a fixed order."""
        word = state & self.layout.flag_mask
        expander = self._expanders.get(word)
        if expander is None:
            calls = self._calls[word] = self._calls.get(word, 0) + 1
            expander = self._blockwise(word) if calls == 1 else self._several[word]
            if calls > SYMBOLIC.compiled_from:
                expander = self._expanders[word] = self._expander(word)
        return expander(state)

    def is_fresh(self, state: int) -> bool:
        """Whether no state of these flags was expanded yet: the first time takes long."""
        return state & self.layout.flag_mask not in self._calls

    def after(self, state: int, number: int) -> int:
        """The state after an action that can be done."""
        found = self.following(state, number)
        assert found is not None
        return found

    def following(self, state: int, number: int) -> int | None:
        """The state after an action; None where it cannot be done."""
        return next((following for following, action in self.expand(state) if action == number), None)

    def blocks(self, state: int) -> list[Block]:
        """The blocks of the successor function of a state."""
        word = state & self.layout.flag_mask
        if word not in self._blocks_of:
            found = (b for flat in self.domains.rules for b in self._blocks.of(flat, self.word(word)))
            self._blocks_of[word] = list({id(b): b for b in found}.values())
        return self._blocks_of[word]

    def witnesses(self, block: Block, numbers: tuple[int, ...]) -> Iterator[tuple[Environment, Step | None, int]]:
        """As `BlockMaker.witnesses`: the values of variables by which a block gives its actions."""
        return self._blocks.witnesses(block, numbers)

    def action(self, number: int) -> Action:
        return self._actions[number]

    def cost(self, number: int) -> float:
        return self._costs[number]

    @property
    def action_count(self) -> int:
        """How many actions have been met so far."""
        return len(self._actions)

    def is_goal(self, state: int) -> bool:
        word = state & self.layout.flag_mask if self._goal_of_chains else 0
        check = self._goals.get(word)
        if check is None:
            known = self.word(word) if self._goal_of_chains else None
            check = self._goals[word] = self.condition(self.guards.reduce(self._goal, {}, known))
        return check(state)

    def facts(self, state: int) -> frozenset[Fact]:
        """The logic facts that hold in a state, static ones included; symmetric ones in both orders."""
        return self.layout.facts(state)

    def word(self, state: int) -> KnownFacts:
        """The facts between small objects that hold in a state."""
        flags = state & self.layout.flag_mask
        if flags not in self._words:
            self._words[flags] = KnownFacts(self.problem, self.layout.true_flags(flags))
        return self._words[flags]

    def condition(self, formula: Formula) -> Callable[[int], bool]:
        """A compiled ground condition on states."""
        check: Callable[[int], bool] = eval(f"lambda s: bool({source(self.layout, formula)})", {})
        return check

    def source(self) -> str:
        """The Python text generated so far."""
        return "\n".join(self._source(word)[0] for word in self._calls)

    def _action_id(self, flat: FlatRule, env: Environment) -> int:
        args: tuple[Value, ...] = tuple(env[v.name] for v in flat.rule.variables)
        action = Action(flat.rule.name, args)
        if action not in self._ids:
            self._ids[action] = len(self._actions)
            self._actions.append(action)
            self._costs.append(float(self.guards.number(flat.rule.cost, env)))
        return self._ids[action]

    def _blockwise(self, word: int) -> Expander:
        """An expander that asks one block after the other."""
        blocks = self.blocks(word)
        repeating = _repeating(blocks)
        asked = [(self._block_expander(block), id(block) in repeating) for block in blocks]

        def expand(state: int) -> list[Successor]:
            out: list[Successor] = []
            again: list[Successor] = []
            for block, repeats in asked:
                block(state, again if repeats else out)
            out += dict.fromkeys(again)
            return out

        self._several[word] = expand
        return expand

    def _block_expander(self, block: Block) -> BlockExpander:
        found = self._by_block.get(id(block))
        if found is None:
            names: dict[str, Any] = {"apply": apply, "rows_0": block.rows}
            exec("\n".join(["def expand(s, out):", *_block_lines(block, 0, "out")]), names)
            found = self._by_block[id(block)] = names["expand"]
        return found

    def _expander(self, word: int) -> Expander:
        text, names = self._source(word)
        exec(compile(text, f"<successors {word:x}>", "exec"), names)
        expander: Expander = names[f"expand_{word:x}"]
        return expander

    def _source(self, word: int) -> tuple[str, dict[str, Any]]:
        """The text of the expander of a word, and what it names."""
        blocks = self.blocks(word)
        repeating = _repeating(blocks)
        names: dict[str, Any] = {"apply": apply}
        lines = [f"def expand_{word:x}(s):", "    out = []"]
        for i, block in enumerate(blocks):
            names[f"rows_{i}"] = block.rows
            shown = ", ".join(str(block.env[v.name]) for v in block.flat.rule.variables if v.name in block.env)
            lines.append(f"    # {block.flat.rule.name}: {shown}")
            lines += _block_lines(block, i, "again" if id(block) in repeating else "out")
        if repeating:
            lines[1:2] = ["    out, again = [], []"]
            lines.append("    out += dict.fromkeys(again)")
        lines.append("    return out")
        return "\n".join(lines) + "\n", names


def apply(s: int, row: tuple[Step, ...], out: list[Successor]) -> None:
    """Append the successors by the steps of a general row."""
    for step in row:
        for mask, value, same in step.tests:
            if (s & mask == value) is not same:
                break
        else:
            step.apply(s, out)


def _block_lines(block: Block, i: int, out: str) -> list[str]:
    reads = [f"s >> {place.shift} & {place.mask}" for _, place in block.keys]
    key = reads[0] if len(reads) == 1 else f"({', '.join(reads)})" if reads else "()"
    lines = [f"r = rows_{i}[{key}]"]
    if not block.simple:
        lines.append(f"apply(s, r, {out})")
    else:
        lines += _guard_lines(block)
        if not block.loops:
            lines += ["if r:", f"    {out}.append((s & {block.keep} | {block.set} | r[0][0], r[0][1]))"]
        else:
            lines += ["if r:", f"    b = s & {block.keep} | {block.set}", f"    {out} += [(b | q, a) for q, a in r]"]
    if block.tests != "True":
        lines = [f"if {block.tests}:", *(f"    {line}" for line in lines)]
    return [f"    {line}" for line in lines]


def _guard_lines(block: Block) -> list[str]:
    """Of a row, only what gives no field a second value."""
    if not block.guarded:
        return []
    free = " and ".join(f"s & {mask} in (0, q & {mask})" for mask in block.guarded)
    return [f"if s & {sum(block.guarded)}:", f"    r = [(q, a) for q, a in r if {free}]"]


def _repeating(blocks: list[Block]) -> set[int]:
    """The blocks that can give the same action as another one or twice, by different witnesses of its condition."""
    found: set[int] = set()
    seen: dict[tuple[object, ...], Block] = {}
    for block in blocks:
        if not block.simple and any(v in block.flat.hidden for v in block.loops):
            found.add(id(block))
        key = (block.flat.rule.name, *(block.env.get(v.name) for v in block.flat.rule.variables))
        first = seen.setdefault(key, block)
        if first is not block:
            found |= {id(first), id(block)}
    return found


def has_chains(formula: Formula) -> bool:
    """Whether a formula quantifies over chains."""
    return any(isinstance(part, ChainType) for part in parts(formula))
