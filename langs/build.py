"""Parse tree to syntax tree, second half: declarations and the items of modules, scenes and tasks."""

from __future__ import annotations

from collections.abc import Iterable

from lark import Token, Tree

from . import syntax as s
from .build_terms import Branch, Child, TermBuilder, branches, tokens
from .syntax_parts import Physical

PHYSICAL = ("stated", "holds")


class TreeBuilder(TermBuilder):
    """Builds the declarations of one file. `lines` are the lines of its text, where doc comments are looked up."""

    def declaration(self, tree: Branch) -> s.Declaration:
        match str(tree.data):
            case "import":
                return self._import(tree)
            case "type_decl":
                name, parent = tree.children
                return s.TypeDecl(str(name), _word(parent), self._doc(tree), span=self.span(tree))
            case "predicate_decl":
                return self._predicate(tree)
            case "derived_decl":
                body = self.formula(tree.children[-1])
                return s.DerivedDecl(
                    str(tree.children[0]), self.signature(tree), body, self._doc(tree), span=self.span(tree)
                )
            case "function_decl":
                name, parameters, value = tree.children
                return s.FunctionDecl(
                    str(name), self.parameters(parameters), self.term(value), self._doc(tree), span=self.span(tree)
                )
            case "motion_decl":
                symmetric = any(t.type == "SYMMETRIC" for t in tokens(tree))
                return s.MotionDecl(
                    str(tree.children[0]),
                    self.signature(tree),
                    symmetric,
                    self._motion_items(tree),
                    self._doc(tree),
                    _word(next((c for c in tree.children[1:] if isinstance(c, Token) and c.type == "NAME"), None)),
                    span=self.span(tree),
                )
            case "rule_decl":
                return self._rule(tree)
            case "placement_decl":
                subject, support, effects = tree.children
                return s.PlacementDecl(
                    self._single(subject),
                    self._single(support),
                    self.effects(effects),
                    self._doc(tree),
                    span=self.span(tree),
                )
            case "heuristic_decl":
                return self._heuristic(tree)
            case "module_decl":
                return self._module(tree)
            case "scene_decl":
                return s.SceneDecl(
                    str(tree.children[0]),
                    self.parameters(tree.children[1]),
                    self._items(tree.children[2:]),
                    self._doc(tree),
                    span=self.span(tree),
                )
        return s.TaskDecl(
            str(tree.children[0]),
            self.parameters(tree.children[1]),
            self._items(tree.children[2:]),
            self._doc(tree),
            span=self.span(tree),
        )

    def _doc(self, tree: Branch) -> str:
        """The `##` lines right above, without their marks."""
        found: list[str] = []
        above = (tree.meta.line or 1) - 2
        while above >= 0 and self._lines[above].lstrip().startswith("##"):
            found.append(self._lines[above].strip().lstrip("#").strip())
            above -= 1
        return "\n".join(reversed(found))

    def _import(self, tree: Branch) -> s.Import:
        words = tokens(tree)
        is_path = words[0].type == "STRING"
        target = self.text(words[0]).value if is_path else ".".join(words)
        return s.Import(target, is_path, span=self.span(tree))

    # --- logic and rules -----------------------------------------------------------------------------------------

    def _predicate(self, tree: Branch) -> s.PredicateDecl:
        static = symmetric = False
        functional_in: str | None = None
        for flag in branches(tree, "flag"):
            token = tokens(flag)[0]
            repeated = {"STATIC": static, "SYMMETRIC": symmetric}.get(token.type, functional_in is not None)
            if repeated:
                self.problem("E0001", "this is said twice", self.span(flag))
            static = static or token.type == "STATIC"
            symmetric = symmetric or token.type == "SYMMETRIC"
            functional_in = str(token) if token.type == "NAME" else functional_in
        return s.PredicateDecl(
            str(tree.children[0]),
            self.signature(tree),
            static,
            symmetric,
            functional_in,
            self._doc(tree),
            span=self.span(tree),
        )

    def _motion_items(self, tree: Branch) -> tuple[s.MotionItem, ...]:
        kinds = ("switch_row", "during_row", "keep_row", "touching_item", "motion_for")
        return tuple(self._motion_item(c) for c in branches(tree, *kinds))

    def _motion_item(self, tree: Branch) -> s.MotionItem:
        span, children = self.span(tree), tree.children
        if tree.data == "motion_for":
            return s.MotionFor(self.binders(children[0]), self._motion_items(tree), span=span)
        if tree.data == "touching_item":
            first, second = map(self.term, children)
            return s.MotionTouching(first, second, span=span)
        if tree.data == "keep_row":
            return s.MotionRow("keep", self.term(children[0]), "", None, span=span)
        when = "switch" if tree.data == "switch_row" else "during"
        return s.MotionRow(when, self.term(children[0]), str(children[1]), self.term(children[2]), span=span)

    def _rule(self, tree: Branch) -> s.RuleDecl:
        name, parameters, pre, where, post, cost = tree.children
        return s.RuleDecl(
            str(name),
            self.parameters(parameters),
            self._conjuncts(pre),
            self._conjuncts(where),
            () if post is None else self.effects(_child(post)),
            None if cost is None else self.term(_child(cost)),
            self._doc(tree),
            span=self.span(tree),
        )

    def _conjuncts(self, node: Child) -> tuple[s.Formula, ...]:
        return () if node is None else self.formulas(_child(node).children)

    def effects(self, node: Child) -> tuple[s.EffectItem, ...]:
        assert isinstance(node, Tree)
        self._enter(node)
        try:
            return tuple(self._effect(c) for c in branches(node))
        finally:
            self._depth -= 1

    def _effect(self, tree: Branch) -> s.EffectItem:
        span, children = self.span(tree), tree.children
        match str(tree.data):
            case "effect_if":
                return s.EffectIf(self.formula(children[0]), self.effects(children[1]), span=span)
            case "effect_for":
                return s.EffectFor(self.binders(children[0]), self.effects(children[1]), span=span)
            case "deletion":
                return s.Effect(self.literal(branches(tree)[0]), True, span=span)
        return s.Effect(self.literal(tree), False, span=span)

    def _single(self, node: Child) -> s.Parameter:
        assert isinstance(node, Tree)
        return self._grouped(node)[0]

    def _heuristic(self, tree: Branch) -> s.HeuristicDecl:
        start = branches(tree, "start_value")
        cases = tuple(self._case(c) for c in branches(tree, "heuristic_case"))
        return s.HeuristicDecl(
            str(tree.children[0]),
            self.parameters(tree.children[1]),
            self.term(start[0].children[0]) if start else None,
            cases,
            self._doc(tree),
            span=self.span(tree),
        )

    def _case(self, tree: Branch) -> s.HeuristicCase:
        rule, *parameters = tokens(tree)
        return s.HeuristicCase(
            str(rule), tuple(map(str, parameters)), self.term(tree.children[-1]), span=self.span(tree)
        )

    # --- modules -------------------------------------------------------------------------------------------------

    def _module(self, tree: Branch) -> s.ModuleDecl:
        name, parameters, urdf, *items = tree.children
        built = tuple(self._module_item(i) for i in items if isinstance(i, Tree))
        return s.ModuleDecl(
            str(name),
            self.parameters(parameters),
            self.text(urdf) if isinstance(urdf, Token) else None,
            built,
            self._doc(tree),
            span=self.span(tree),
        )

    def _module_item(self, tree: Branch) -> s.ModuleItem:
        span, children = self.span(tree), tree.children
        match str(tree.data):
            case "effector_item":
                physics = branches(tree, *PHYSICAL)
                name, kind, *link, shape, at, normal = _without(children, physics)
                return s.EffectorItem(
                    str(name),
                    _word(kind),
                    self.text(link[0]) if link and isinstance(link[0], Token) else None,
                    None if shape is None else self.call(_tree(shape)),
                    self.maybe_term(at),
                    self.maybe_term(normal),
                    physics=self.physics(physics),
                    span=span,
                )
            case "joint_item":
                physics = branches(tree, *PHYSICAL)
                name, call, limits, home, speed, acceleration, jerk, passive = _without(children, physics)
                motion = None if call is None else self.call(_tree(call))
                named = isinstance(name, Token) and name.type == "STRING"
                lower, upper = (None, None) if limits is None else self.terms(_tree(limits).children)
                return s.JointItem(
                    str(name)[1:-1] if named else str(name),
                    None if motion is None else motion.function,
                    () if motion is None else motion.args,
                    lower,
                    upper,
                    self.maybe_term(home),
                    self.maybe_term(speed),
                    self.maybe_term(acceleration),
                    self.maybe_term(jerk),
                    passive is not None,
                    physics=self.physics(physics),
                    span=span,
                )
            case "coupling_item":
                return s.CouplingItem(str(children[0]), self.term(children[1]), span=span)
            case "link_item":
                between = children[1]
                drawn = None if between is None else self.call(_tree(between))
                physics = branches(tree, *PHYSICAL)
                return s.LinkItem(self.term(children[0]), drawn, physics=self.physics(physics), span=span)
            case "branch_item":
                return s.BranchItem(self._branch_items(tree), span=span)
        return self._fact(tree)

    def _branch_items(self, tree: Branch) -> tuple[s.ModuleItem, ...]:
        self._enter(tree)
        try:
            return tuple(self._module_item(i) for i in branches(tree))
        finally:
            self._depth -= 1

    def _fact(self, tree: Branch) -> s.FactItem:
        return s.FactItem(self.literal(branches(tree)[0]), span=self.span(tree))

    def physics(self, clauses: Iterable[Branch]) -> tuple[Physical, ...]:
        """What a part weighs, bears and holds."""
        return tuple(self._physical(c) for c in clauses)

    def _physical(self, tree: Branch) -> Physical:
        word = str(tree.children[0])
        if tree.data == "stated":
            return s.Stated(word, self.term(tree.children[1]), span=self.span(tree))
        strengths = [(str(b.children[0]), self.term(b.children[1])) for b in branches(tree, "strength")]
        return s.Holds(word, tuple(strengths), span=self.span(tree))

    # --- scenes and tasks ----------------------------------------------------------------------------------------

    def _items(self, nodes: Iterable[Child]) -> tuple[s.SceneItem, ...]:
        return tuple(self._item(n) for n in nodes if isinstance(n, Tree))

    def _item(self, tree: Branch) -> s.SceneItem:
        self._enter(tree)
        try:
            return self._scene_item(tree)
        finally:
            self._depth -= 1

    def _scene_item(self, tree: Branch) -> s.SceneItem:
        span, children = self.span(tree), tree.children
        match str(tree.data):
            case "body_item":
                return self._body(tree)
            case "robot_on" | "robot_at":
                return self._robot(tree)
            case "fact_item":
                return self._fact(tree)
            case "for_item":
                return s.ForItem(self.binders(children[0]), self._items(children[1:]), span=span)
            case "if_item":
                return s.IfItem(self.formula(children[0]), self._items(children[1:]), span=span)
            case "scene_use":
                return s.SceneUse(str(children[0]), self._arguments(children[1]), span=span)
            case "guide_use":
                return s.GuideUse(str(children[0]), self._arguments(children[1]), span=span)
            case "goal_item":
                return s.GoalItem(self._conjuncts(tree), span=span)
            case "course_item":
                return self._course(tree)
            case "disturbance_item":
                body, by, time = self.terms(children)
                return s.DisturbanceItem(body, by, time, span=span)
            case "breakdown_item":
                module, time = self.terms(children[:2])
                return s.BreakdownItem(module, time, str(children[2]), span=span)
        entries = [
            ("minimise" if o.data == "objective" else str(o.children[0]), self.term(o.children[-1]))
            for o in branches(tree, "option", "objective")
        ]
        return s.OptionsItem(tuple(entries), span=span)

    def _body(self, tree: Branch) -> s.BodyItem:
        physics = branches(tree, *PHYSICAL)
        kind, name, shape, on, at, heading = _without(tree.children, physics)
        return s.BodyItem(
            str(kind),
            self.term(name),
            self.call(_tree(shape)),
            self.maybe_term(on),
            self.maybe_term(at),
            self.maybe_term(heading),
            physics=self.physics(physics),
            span=self.span(tree),
        )

    def _robot(self, tree: Branch) -> s.RobotItem:
        kind, args, name, *rest = tree.children
        effector, on = (str(rest.pop(0)), rest.pop(0)) if tree.data == "robot_on" else (None, None)
        at, heading = rest
        return s.RobotItem(
            str(kind),
            self._arguments(args),
            self.term(name),
            effector,
            self.maybe_term(on),
            self.maybe_term(at),
            self.maybe_term(heading),
            span=self.span(tree),
        )

    def _course(self, tree: Branch) -> s.CourseItem:
        body, *points, speed, start, returns = tree.children
        return s.CourseItem(
            self.term(body),
            self.terms(points),
            self.term(speed),
            self.maybe_term(start),
            returns is not None,
            span=self.span(tree),
        )

    def _arguments(self, node: Child) -> tuple[s.Argument, ...]:
        if node is None:
            return ()
        made: list[s.Argument] = []
        for argument in branches(_tree(node)):
            name = str(argument.children[0]) if argument.data == "named" else None
            made.append(s.Argument(name, self.term(argument.children[-1]), span=self.span(argument)))
        return tuple(made)


def _without(children: Iterable[Child], others: Iterable[Branch]) -> list[Child]:
    """`children` but for some trees among them."""
    left_out = {id(o) for o in others}
    return [c for c in children if id(c) not in left_out]


def _word(node: Child) -> str | None:
    return None if node is None else str(node)


def _tree(node: Child) -> Branch:
    assert isinstance(node, Tree)
    return node


def _child(node: Child) -> Branch:
    return _tree(_tree(node).children[0])
