"""std.thesis says what the appendix of the thesis says, and replays the sizes of its search trees."""

from __future__ import annotations

import heapq
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import pytest

from tamplang.compiler.imports import load_library
from tamplang.compiler.ir import Action, Problem
from tamplang.compiler.pipeline import compile_text
from tamplang.compiler.symbolic.costs import CostToGo
from tamplang.compiler.symbolic.successors import Successors
from tamplang.langs import syntax

ROOT = Path(__file__).parents[2]

APPENDIX = {
    "step": """(gripper A) (support A) (busy A) (gripper B) ¬(support B) ¬(busy B) (linked A B) ¬(connected A B)
        (object X) (base X) (on X A) (object Y) (base Y) ¬(grippable X) ¬(grippable Y) ¬(INFEASIBLE step A B X Y)
        POST ¬(busy A) ¬(support A) ¬[stable ANY A] ¬(on X A) ¬[touch A X] (busy B) (support B) (on Y B) [stable Y B]
        [touch Y B]""",
    "grasp": """(gripper A) ¬(busy A) ¬(support A) (object X) ¬(gripper X) (grippable X) ¬(held X) ¬(placed X)
        ¬(INFEASIBLE grasp A X)
        POST ¬[stable ANY X] (busy A) (held X) (grasped A X) [stable A X] [touch A X]""",
    "place": """(gripper A) (grasped A X) (tray Y) (held X) ¬(INFEASIBLE place A X Y)
        POST ¬(grasped A X) ¬(busy A) ¬(busy X) ¬(held X) (placed X) ¬[stable X ANY] (on Y X) ¬[touch A X] [touch X Y]
        [above X Y] [stable Y X] ¬[stable A X]""",
    "connect": """(gripper A) (support A) (busy A) ¬(onMobile A) (gripper B) ¬(support B) ¬(busy B) (linked A B)
        (gripper C) ¬(support C) ¬(busy C) (gripper D) (support D) (busy D) (linked C D) ¬(equal B C) ¬(equal A D)
        ¬(INFEASIBLE connect A B C D)
        POST ¬(busy A) ¬(support A) ¬[stable ANY A] ¬(on ANY A) (busy B) (busy C) (connected B C) (connected C B)
        [stable C B] [connectCrawlers C B]""",
    "disconnect": """(gripper A) ¬(support A) ¬(busy A) (busy B) (busy C) (linked A B) ¬(equal A B) (linked C D)
        ¬(equal C D) (connected B C) (gripper D) (support D) (on X D) ¬(INFEASIBLE disconnect A B C D X)
        POST (support A) (busy A) [stable X A] [touch X A] (on X A) ¬(busy B) ¬(support B) ¬[stable ANY B] ¬(busy C)
        ¬(support C) ¬[stable C ANY] ¬[stable B C] ¬(connected B C) ¬(connected C B) ¬[connectCrawlers B C]
        ¬[connectCrawlers C B] ¬[touch B C] ¬[touch C B]""",
    "stepTogether": """(gripper A) (support A) (busy A) (gripper B) ¬(support B) (busy B) (gripper C) ¬(support C)
        (busy C) (gripper D) ¬(support D) ¬(busy D) (connected B C) (linked A B) (linked C D) (object X) ¬(grippable X)
        (object Y) ¬(grippable Y) (on X A) ¬(INFEASIBLE stepTogether A B C D X Y)
        POST ¬(busy A) ¬(support A) ¬[stable ANY A] ¬(on X A) (busy D) (support D) [stable Y D] [touch Y D] (on Y D)
        ¬[stable B ANY] ¬[stable ANY C] [touch C B] [stable C B]""",
    "connect2mobileBase": """(gripper A) (support A) (busy A) (gripper B) ¬(support B) ¬[stable ANY B] ¬(busy B)
        (linked A B) ¬(connected A B) (object X) ¬(gripper X) (on X A) (object Y) (mobile Y) ¬(busy Y)
        ¬(INFEASIBLE connect2mobileBase A B X Y)
        POST ¬(busy A) ¬(support A) ¬[stable ANY A] ¬(on X A) (busy B) (support B) [stable Y B] (on Y B) (busy Y)
        (onMobile B) [touchBoxNormalX B Y]""",
}


def said_in_the_appendix(rule: str) -> list[str]:
    text = APPENDIX[rule].replace("touchBoxNormalX", "touchBoxNormal")
    before, after = text.split("POST")
    conditions = re.findall(r"¬?[\[(][^\])]*[\])]", before)
    effects = re.findall(r"¬?[\[(][^\])]*[\])]", after)
    kept = [c for c in conditions if "INFEASIBLE" not in c and "[" not in c]
    return [*kept, "POST", *(e for e in effects if "(held" not in e)]


def shown(literal: syntax.Literal) -> str:
    names = [a.name if isinstance(a, syntax.Name) else "ANY" for a in literal.args]
    text = " ".join([literal.predicate, *names])
    return f"[{text}]" if literal.motion else f"({text})"


def conditions(formulas: Sequence[syntax.Formula]) -> Iterator[str]:
    for formula in formulas:
        negated = isinstance(formula, syntax.Not)
        inner = formula.operand if isinstance(formula, syntax.Not) else formula
        if isinstance(inner, syntax.Compare):
            assert isinstance(inner.left, syntax.Name) and isinstance(inner.right, syntax.Name)
            yield "¬" * negated + f"(equal {inner.left.name} {inner.right.name})"
        else:
            assert isinstance(inner, syntax.Literal)
            yield "¬" * negated + shown(inner)


@pytest.mark.parametrize("rule", APPENDIX)
def test_rule_stands_as_in_the_appendix(rule: str) -> None:
    declared = load_library(ROOT / "stdlib" / "thesis.tamp").rules[rule]
    effects = [e for e in declared.post if isinstance(e, syntax.Effect)]
    said = ["¬" * e.negated + shown(e.literal) for e in effects]
    assert len(effects) == len(declared.post) and declared.where == ()
    assert [*conditions(declared.pre), "POST", *said] == said_in_the_appendix(rule)


CLIMB = """
import std.crawler
import std.thesis
import std.scenes
task climb(n: int, crawlers: int = 1) {
    scene stairs(n)
    object target: sphere(4 cm) at (0.35 m * n + 0.3 m, 0, 0.20 m * n + 0.7 m)
    fact (grippable target)
    for k in 1 .. crawlers {
        crawler c[k]: A on ground at (0.7 m, 0.35 m * k)
    }
    goal  (held target)
    guide costToGo1and2(target)
}
"""


@dataclass(frozen=True, slots=True)
class _Node:
    state: int
    parent: int
    action: int | None


@dataclass(slots=True)
class PlainSearch:
    """The thesis' own search (algorithm 1): best-first by the cost-to-go of the task's guide alone. No state is ever
    recognised again, no cost of actions counts, and a child with a high cost-to-go stays in the tree, so that the size
    of the tree is the root and all children of the nodes that were expanded.

    `tree_nodes` counts all nodes with the root, `expanded_nodes` those expanded after the root, as the thesis does.
    `most_nodes` bounds the tree."""

    problem: Problem
    successors: Successors
    most_nodes: int
    expanded_nodes: int = -1
    nodes: list[_Node] = field(default_factory=list)

    @property
    def tree_nodes(self) -> int:
        return len(self.nodes)

    def goals(self) -> Iterator[tuple[Action, ...]]:
        """The plans in the order in which their last node leaves the queue; ends when the tree is full."""
        guide, successors = CostToGo(self.problem, self.successors), self.successors
        self.nodes.append(_Node(successors.initial, -1, None))
        queue = [(guide.start, 0)]
        while queue and len(self.nodes) < self.most_nodes:
            value, index = heapq.heappop(queue)
            node = self.nodes[index]
            if successors.is_goal(node.state):
                yield self._plan(index)
                continue
            self.expanded_nodes += 1
            for following, action in successors.expand(node.state):
                change = guide.change(node.state, action, node.action)
                heapq.heappush(queue, (value + change, len(self.nodes)))
                self.nodes.append(_Node(following, index, action))

    def _plan(self, index: int) -> tuple[Action, ...]:
        actions = []
        while (action := self.nodes[index].action) is not None:
            actions.append(self.successors.action(action))
            index = self.nodes[index].parent
        return tuple(reversed(actions))


def replayed(n: int, crawlers: int) -> tuple[PlainSearch, list[str]]:
    problem, warnings = compile_text(CLIMB, parameters={"n": str(n), "crawlers": str(crawlers)})
    assert {w.code for w in warnings} <= {"W0004"}
    search = PlainSearch(problem, Successors(problem), 20_000)
    return search, [a.rule for a in next(search.goals())]


@pytest.mark.parametrize("n", [1, 2, 4, 8, 16, 32])
def test_one_crawler_grows_the_trees_of_the_thesis(n: int) -> None:
    search, rules = replayed(n, 1)
    assert search.tree_nodes == (search.expanded_nodes + 1) * (n + 2) + 1
    assert rules == ["step"] * (len(rules) - 1) + ["grasp"]


def test_first_row_of_table_4() -> None:
    search, rules = replayed(1, 1)
    assert (search.tree_nodes, search.expanded_nodes, len(rules)) == (10, 2, 2)


def test_two_crawlers_connect_and_climb_together() -> None:
    _, rules = replayed(8, 2)
    assert rules[0] == "connect" and set(rules[1:-1]) == {"stepTogether"} and rules[-1] == "grasp"


def test_states_are_not_recognised_again() -> None:
    both_feet = "goal (on stair[1] c[1].A), (on stair[1] c[1].B)"
    text = CLIMB.replace("goal  (held target)", both_feet).replace("guide costToGo1and2(target)", "")
    problem, _ = compile_text(text, parameters={"n": "1"})
    search = PlainSearch(problem, Successors(problem), 1000)
    assert next(search.goals(), None) is None
    assert search.tree_nodes >= 1000
