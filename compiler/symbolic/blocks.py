"""Blocks of the successor functions: a rule with its small variables bound, lifted over its locations.

A block reads the values of some fields (its keys), and gives for each of them a row: the actions with their effects.
Rows are built when they are first looked up.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

from ...langs.trees import parts
from ..ir import (
    Any_,
    Effect,
    EffectIf,
    EffectItem,
    Formula,
    Literal,
    Object,
    Or,
    Term,
    Var,
    Variable,
)
from .algebra import Environment, Undefined, conjunction
from .bindings import Bindings
from .chains import KnownFacts
from .domains import FlatRule
from .expressions import Check, compiled, ground, literal_test, source, split
from .guards import Guards
from .layout import FIELD, STATIC, Field, Layout
from .normal_form import TRUE, free_names
from .steps import Addition, Step

Change = tuple[Formula, Literal, bool]
"""A condition, the literal that changes where it holds, and whether it is deleted."""
Entry = tuple[int, int]
"""Bits to set, action."""


@dataclass(slots=True)
class Block:
    """`keys` are the fields whose values bind variables; `tests` is Python source that must hold first. In a simple
    block, the fields `guarded` get a value though they may have another one, and the bits `excluded` must not be set
    beside what is added."""

    flat: FlatRule
    env: Environment
    keys: tuple[tuple[str, Field], ...]
    loops: tuple[Variable, ...]
    guards: tuple[Formula, ...]
    changes: tuple[Change, ...]
    tests: str
    simple: bool
    keep: int = -1
    set: int = 0
    guarded: list[int] = field(default_factory=list)
    excluded: int = 0
    values: list[tuple[Term, Field]] = field(default_factory=list)
    rows: dict[Any, Any] = field(default_factory=dict)


ActionId = Callable[[FlatRule, Environment], int]


class BlockMaker:
    """Makes the blocks of a rule for a flag word; equal blocks of different words are one."""

    def __init__(self, guards: Guards, action_id: ActionId) -> None:
        self.guards = guards
        self.layout: Layout = guards.layout
        self.action_id = action_id
        self._made: dict[Any, Block | None] = {}
        self._bindings = Bindings(guards, self._bound)
        self._keys: dict[str, list[str]] = {}
        for predicate, key in self.layout.fields:
            self._keys.setdefault(predicate, []).append(key)

    def of(self, flat: FlatRule, word: KnownFacts) -> list[Block]:
        """The blocks of one rule whose conditions on the flags hold."""
        domains = self.layout.domains.variable_domains(flat)
        small = [v for v in flat.variables if v.name not in domains or domains[v.name] <= self.layout.small]
        return list({id(block): block for block in self._bindings.of(flat, small, domains, word)}.values())

    def _bound(
        self, flat: FlatRule, env: Environment, rest: tuple[Formula, ...], word: KnownFacts
    ) -> Block | None:
        """The block of values of the small variables, where something is left of it."""
        changes = tuple(self._changes(flat.rule.effects, env, word))
        shown = tuple(env.get(v.name) for v in flat.variables)
        key = (flat.rule.name, shown, rest, changes)
        if key not in self._made:
            large = [v for v in flat.variables if v.name not in env]
            self._made[key] = self._block(flat, env, large, rest, changes)
        return self._made[key]

    def _changes(self, items: Sequence[EffectItem], env: Environment, word: KnownFacts) -> list[Change]:
        """Effects without loops, with what is known of their conditions settled."""
        found: list[Change] = []
        for item in items:
            if isinstance(item, Effect):
                if not item.literal.motion:
                    found.extend(self._change(item, env))
            elif isinstance(item, EffectIf):
                condition = self.guards.reduce(item.condition, env, word)
                if condition == Or(()):
                    continue
                for inner, literal, negated in self._changes(item.effects, env, word):
                    found.append((conjunction((condition, inner)), literal, negated))
            else:
                for inner_env, _ in self.guards.solutions(item.variables, (), env, word):
                    found.extend(self._changes(item.effects, inner_env, word))
        return found

    def _change(self, effect: Effect, env: Environment) -> list[Change]:
        try:
            args = tuple(self.guards.resolve(a, env) for a in effect.literal.args)
        except Undefined:
            return []
        return [(TRUE, Literal(effect.literal.predicate, args), effect.negated)]

    def _block(
        self,
        flat: FlatRule,
        env: Environment,
        large: list[Variable],
        conjuncts: tuple[Formula, ...],
        changes: tuple[Change, ...],
    ) -> Block | None:
        keys: dict[str, Field] = {}
        lifted: list[Formula] = []
        ground_tests: list[Formula] = []
        for formula in conjuncts:
            bound = self._key(formula, {v.name for v in large})
            if bound is not None and bound[0] not in keys:
                keys[bound[0]] = bound[1]
            elif free_names(formula) - env.keys():
                lifted.append(formula)
            else:
                ground_tests.append(formula)
        tests = source(self.layout, conjunction(ground_tests))
        if tests == "False":
            return None
        loops = tuple(v for v in large if v.name not in keys)
        plain = all(self._static(f) for f in lifted)
        block = Block(flat, env, tuple(keys.items()), loops, tuple(lifted), changes, tests, plain)
        block.simple = plain and self._settle(block)
        if block.simple and block.excluded:
            block.tests = f"not s & {block.excluded}" + (f" and {tests}" if tests != "True" else "")
        if block.keys or not block.simple:
            block.rows = BlockRows(self, block)
        else:
            block.rows = {(): self.row(block, ())}
            if not block.rows[()]:
                return None
        return block

    def _key(self, formula: Formula, large: set[str]) -> tuple[str, Field] | None:
        """The variable that a positive functional literal with a known key binds to a field's value."""
        if not isinstance(formula, Literal) or self.layout.kinds[formula.predicate] != FIELD:
            return None
        key_at = self.guards.problem.predicates[formula.predicate].functional_in or 0
        key, value = formula.args[key_at], formula.args[1 - key_at]
        if not isinstance(key, Object) or not isinstance(value, Var) or value.name not in large:
            return None
        place = self.layout.fields.get((formula.predicate, key.name))
        return None if place is None else (value.name, place)

    def _static(self, formula: Formula) -> bool:
        literals = (part for part in parts(formula) if isinstance(part, Literal))
        return all(self.layout.kinds[literal.predicate] == STATIC for literal in literals)

    def _settle(self, block: Block) -> bool:
        """Effects that are the same for a whole block; False when some depend on more than added values."""
        keys = dict(block.keys)
        for deleting in (True, False):
            for condition, literal, negated in block.changes:
                if negated is not deleting:
                    continue
                if condition != TRUE or not self._settle_one(block, keys, literal, negated):
                    return False
        return True

    def _settle_one(self, block: Block, keys: dict[str, Field], literal: Literal, negated: bool) -> bool:
        if self.layout.kinds[literal.predicate] != FIELD:
            if not all(isinstance(a, Object) for a in literal.args):
                return False
            bit = self.layout.encode(ground(literal))[0]
            block.keep &= ~bit
            if not negated:
                others = self.layout.others(ground(literal))
                if block.set & others:
                    return False
                block.excluded |= others & block.keep
                block.set |= bit
            return True
        key_at = self.guards.problem.predicates[literal.predicate].functional_in or 0
        key, value = literal.args[key_at], literal.args[1 - key_at]
        if not isinstance(key, Object):
            return False
        place = self.layout.fields.get((literal.predicate, key.name))
        if place is None:
            return negated
        if negated and not isinstance(value, Any_) and not (isinstance(value, Var) and keys.get(value.name) is place):
            return False
        mask = place.mask << place.shift
        if not negated:
            if any(known is place for _, known in block.values):
                return False
            if block.keep & mask:
                block.guarded.append(mask)
            block.values.append((value, place))
        block.keep &= ~mask
        return True

    # --- rows ----------------------------------------------------------------------------------------------------

    def row(self, block: Block, numbers: tuple[int, ...]) -> tuple[Any, ...]:
        """The actions of a block for the numbers that its key fields hold."""
        found = self._joined(block, numbers)
        if block.simple:
            return tuple(dict.fromkeys(self._entry(block, env) for env, _ in found))
        steps: dict[Any, Step] = {}
        for env, rest in found:
            step = self._step(block, env, rest)
            if step is not None:
                steps.setdefault((step.tests, step.check, step.action), step)
        return tuple(steps.values())

    def witnesses(self, block: Block, numbers: tuple[int, ...]) -> Iterator[tuple[Environment, Step | None, int]]:
        """By what values of all variables a block gives its actions: the values, the step in whose states they do so
        (None: wherever the block gives anything), and the action."""
        for env, rest in self._joined(block, numbers):
            if block.simple:
                yield env, None, self.action_id(block.flat, env)
            else:
                step = self._step(block, env, rest)
                if step is not None:
                    yield env, step, step.action

    def _joined(
        self, block: Block, numbers: tuple[int, ...]
    ) -> Iterable[tuple[Environment, tuple[Formula, ...]]]:
        """All values of the variables of a block for the numbers in its key fields, with what remains of guards."""
        env = dict(block.env)
        for (name, place), number in zip(block.keys, numbers, strict=True):
            if not 1 <= number <= len(place.values):
                return ()
            env[name] = place.values[number - 1]
        kinds = {v.name: v for v in block.flat.variables}
        for name, _ in block.keys:
            if env[name] not in self.guards.values(kinds[name], {}, None):
                return ()
        domains = self.layout.domains.variable_domains(block.flat)
        return self.guards.solutions(block.loops, block.guards, env, None, domains)

    def _entry(self, block: Block, env: Environment) -> Entry:
        bits = 0
        for value, place in block.values:
            known = self.guards.resolve(value, env)
            bits |= place.numbers[known.name] << place.shift if isinstance(known, Object) else 0
        return bits, self.action_id(block.flat, env)

    def _step(self, block: Block, env: Environment, rest: Sequence[Formula]) -> Step | None:
        tests, others = split(self.layout, rest)
        if tests is None:
            return None
        check = compiled(self.layout, conjunction(others)) if others else None
        keep, bits = -1, 0
        drops: list[tuple[int, int]] = []
        guards: list[Addition] = []
        dropped: list[tuple[Check, int]] = []
        added: list[tuple[Check, Addition]] = []
        for condition, literal, negated in self._ground_changes(block, env):
            check_ = None if condition == TRUE else compiled(self.layout, condition)
            drop = self._drop(condition, literal) if negated else None
            if drop is not None:
                drops.append(drop)
            elif negated and check_ is None:
                keep &= self._deletion(literal)
            elif negated and check_ is not None:
                dropped.append((check_, self._deletion(literal)))
            elif check_ is None:
                guards.append(self._addition(literal))
                bits |= guards[-1][2]
            else:
                added.append((check_, self._addition(literal)))
        if any(bits & mask not in (0, value) for mask, value, _ in guards):
            return None
        guarded = tuple(g for g in dict.fromkeys(guards) if keep & g[0])
        action = self.action_id(block.flat, env)
        return Step(tuple(tests), check, tuple(drops), keep, guarded, bits, tuple(dropped), tuple(added), action)

    def _drop(self, condition: Formula, literal: Literal) -> tuple[int, int] | None:
        """Mask and value of a field that is emptied where it holds just that value."""
        if not isinstance(condition, Literal) or self.layout.kinds[literal.predicate] != FIELD:
            return None
        mask, value, same = literal_test(self.layout, condition)
        return (mask, value) if same and self._deletion(literal) == ~mask else None

    def _ground_changes(self, block: Block, env: Environment) -> list[Change]:
        """The changes of one action; deleting one value of a field becomes a condition unless the value is known."""
        found = []
        known = {(place.predicate, place.key): env[name] for name, place in block.keys}
        for condition, literal, negated in block.changes:
            settled = condition if condition == TRUE else self.guards.reduce(condition, env, None)
            args = tuple(self.guards.resolve(a, env) for a in literal.args)
            item = Literal(literal.predicate, args)
            if settled == Or(()):
                continue
            if negated and self.layout.kinds[item.predicate] == FIELD:
                found.extend(self._field_deletions(settled, item, known))
            else:
                found.append((settled, item, negated))
        return found

    def _field_deletions(self, condition: Formula, literal: Literal, known: dict[tuple[str, str], Any]) -> list[Change]:
        key_at = self.guards.problem.predicates[literal.predicate].functional_in or 0
        found: list[Change] = []
        key_arg, value = literal.args[key_at], literal.args[1 - key_at]
        keys = self._keys.get(literal.predicate, ()) if not isinstance(key_arg, Object) else (key_arg.name,)
        for key in keys:
            place = self.layout.fields.get((literal.predicate, key))
            if place is None:
                continue
            whole = self._pair(literal.predicate, key_at, Object(key), Any_())
            if isinstance(value, Any_):
                found.append((condition, whole, True))
            elif isinstance(value, Object) and value.name in place.numbers:
                held = self._pair(literal.predicate, key_at, Object(key), value)
                sure = known.get((literal.predicate, key)) == value.name
                found.append((condition if sure else conjunction((condition, held)), whole, True))
        return found

    @staticmethod
    def _pair(predicate: str, key_at: int, key: Object, value: Object | Any_) -> Literal:
        return Literal(predicate, (key, value) if key_at == 0 else (value, key))

    def _deletion(self, literal: Literal) -> int:
        """The bits to keep when a literal is deleted; fields are cleared whole."""
        if self.layout.kinds[literal.predicate] == FIELD:
            key = next(a.name for a in literal.args if isinstance(a, Object))
            place = self.layout.fields[literal.predicate, key]
            return ~(place.mask << place.shift)
        if all(isinstance(a, Object) for a in literal.args):
            return ~self.layout.encode(ground(literal))[0]
        names = tuple(a.name if isinstance(a, Object) else None for a in literal.args)
        return ~self.layout.matching_bits(literal.predicate, names)

    def _addition(self, literal: Literal) -> Addition:
        fact = ground(literal)
        mask, value = self.layout.encode(fact)
        return (mask, value, value) if self.layout.kinds[fact[0]] == FIELD else (self.layout.others(fact), 0, value)


class BlockRows(dict[Any, Any]):
    """The rows of one block by the numbers in its key fields; built at first use."""

    def __init__(self, blocks: BlockMaker, block: Block) -> None:
        super().__init__()
        self.blocks = blocks
        self.block = block

    def __missing__(self, key: Any) -> tuple[Any, ...]:
        numbers = key if isinstance(key, tuple) else (key,)
        row = self[key] = self.blocks.row(self.block, numbers)
        return row
