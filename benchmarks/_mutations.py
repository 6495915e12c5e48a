"""The mutations of `tamplang bench mutants`: what breaks, where, and the tests that must find it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Mutation:
    """`old`, which occurs once in `file`, becomes `new`; `tests` are pytest's arguments. `reason` tells why a survivor
    is none of the tests' concern."""

    name: str
    file: str
    old: str
    new: str
    tests: tuple[str, ...]
    reason: str = ""


_BLOCK = "tests/symbolic/test_optimal.py::test_optimal_gap_and_estimate_against_brute_force"
BOUNDS = ("tests/symbolic/test_bounds.py",)
BRUTE = ("tests/symbolic/test_bounds.py", *(f"{_BLOCK}[{k}]" for k in (0, 3)))
MEANING = ("tests/symbolic/test_meaning.py::test_planner_and_verifier_agree_on_random_tasks",)
SEARCH = ("tests/symbolic/test_search.py",)
STRAIN = ("tests/symbolic/test_strain.py",)
CLAIMS = ("tests/loop/test_claims.py",)
SLACK = ("tests/search/test_roomy.py",)
PENALTY = ("tests/search/test_surcharge.py",)
LIMITS = ("tests/verify/test_thresholds.py",)
RATES = ("tests/verify/test_rates.py",)
MEASURES = ("tests/verify/test_measures.py",)
TAMPER = ("tests/verify/test_tamper.py",)
SEEDS = ("tests/loop/test_determinism.py", "-k", "seed")
PATHS = ("tests/motion/test_phases_repair.py", "tests/motion/test_phases.py")
NEARBY = ("tests/motion/test_nearby.py", "tests/motion/test_collision.py")
FIGURES = ("tests/report/test_figures.py",)
SENSING = ("tests/horizon/test_steering.py", "tests/horizon/test_world.py")

ALGEBRA, ESTIMATE = "compiler/symbolic/algebra.py", "compiler/symbolic/estimate.py"
LOCATIONS, PRICES = "compiler/symbolic/locations.py", "compiler/symbolic/prices.py"
LINKS = "compiler/symbolic/links.py"
LAYOUT, DOMAINS, STRAINS = "compiler/symbolic/layout.py", "compiler/symbolic/domains.py", "compiler/symbolic/strain.py"
SEARCHES, CONFLICTS, MOTION = "runtime/planner/search", "runtime/planner/conflicts", "runtime/planner/motion"
BEST, NOGOODS = f"{SEARCHES}/best_first.py", f"{CONFLICTS}/forbidden_sequences.py"
ROOMY, SURCHARGE = f"{SEARCHES}/slack_maximisation.py", f"{SEARCHES}/learned_penalties.py"
LGP, JUDGED, SEED = "runtime/planner/lgp.py", "runtime/planner/bounds/verdicts.py", "runtime/seeds.py"
EXPERIENCE, REFUSALS = f"{CONFLICTS}/nogoods.py", f"{CONFLICTS}/infeasibility.py"
FOUND, TABLE, RATE = "runtime/verify/findings.py", "runtime/verify/limits.py", "runtime/verify/rates.py"
DEPTH = "runtime/verify/collision.py"
ATTEMPTS, SMOOTH = f"{MOTION}/phases/attempts.py", f"{MOTION}/phases/smoothing.py"
CLEAR = f"{MOTION}/collision/clearance_rows.py"
VIEW, LINE, TREE = "runtime/report/view.py", "runtime/report/timeline.py", "runtime/report/tree.py"
SENSE, SUCC = "runtime/simulation/sensing.py", "compiler/symbolic/successors.py"

MUTATIONS = [
    # --- symbolic layer: meaning, costs, estimate
    Mutation("rounding slack dropped", ALGEBRA, "right + slack)", "right)", BOUNDS),
    Mutation("equality without slack", ALGEBRA, "abs(left - right), SLACK)", "abs(left - right), -SLACK)", BOUNDS),
    Mutation("conjunction absorbs nothing", ALGEBRA, "            return absorbing\n", "            continue\n",
             MEANING),
    Mutation("estimate: least of counts served", ESTIMATE, "max(counts.values(), default=0)",
             "min(counts.values(), default=0)", BRUTE),
    Mutation("estimate: one landmark served", ESTIMATE, "sum(counts.values()) if", "1 if", BRUTE),
    Mutation("estimate: dearest achiever", ESTIMATE, "landmark.weight = min((", "landmark.weight = max((", BRUTE),
    Mutation("estimate: a cost that depends counts 1", ESTIMATE, "isinstance(cost, Number) else 0.0",
             "isinstance(cost, Number) else 3.0", BRUTE),
    Mutation("estimate: hops added to what they serve", ESTIMATE, '"    total += hops" if self.separate',
             '"    total += hops" if True', SEARCH),
    Mutation("estimate: symmetric facts one way", ESTIMATE, "orders.append(fact[:0:-1])",
             "orders.append(fact[1:])", BRUTE),
    Mutation("estimate: what holds at the start is a landmark", ESTIMATE,
             "if union and not any(", "if union and any(", BRUTE),
    Mutation("edge costs ignored", LOCATIONS, "better = near & (best > cost + edge.cost)",
             "better = near & (best > cost + 1e-9)", BOUNDS),
    Mutation("edge costs counted as nothing", LOCATIONS, "best[better] = cost + edge.cost", "best[better] = cost",
             SEARCH),
    Mutation("priced distances without their start", PRICES, "costs[here] + best[place])", "costs[here])", SEARCH),
    Mutation("links cost the most", LINKS, "self.cost = min((costs", "self.cost = 2 * min((costs", SEARCH),
    Mutation("links one too many", LINKS, "self.most = max((added[name] for name in self.rules), default=1)",
             "self.most = 1", ("tests/symbolic/test_hand_over.py",)),
    Mutation("symmetric effects grow one way", DOMAINS, "range(len(domains)) if symmetric else (k,)",
             "(k,)", (*MEANING, *BRUTE)),
    Mutation("symmetric facts read one way", LAYOUT, "orders = (args, args[::-1]) if symmetric else (args,)",
             "orders = (args,)", MEANING),
    Mutation("symmetric facts told one way", LAYOUT, "found |= {(f[0], f[2], f[1])", "found |= {(f[0], f[1], f[2])",
             MEANING),
    Mutation("functional: keeps the old value", LAYOUT, "set(fact[1:]) if predicate.symmetric",
             "set() if predicate.symmetric", MEANING),
    Mutation("strain of the mildest condition", STRAINS, "return max((self._of_sides(*sides, env)",
             "return min((self._of_sides(*sides, env)", STRAIN),
    Mutation("strain of the worst rule", STRAINS, "return min((self._ratio(flat, env)",
             "return max((self._ratio(flat, env)",
             STRAIN, "the rules of the suite have one flat form each where arguments settle the strain"),
    Mutation("actions given twice", SUCC, 'lines.append("    out += dict.fromkeys(again)")',
             'lines.append("    out += again")', MEANING),
    Mutation("guarded fields get two values", SUCC, "if not block.guarded:", "if True:",
             (*MEANING, "tests/symbolic/test_functional.py"),
             "no task of the tests reaches a simple block that would give a field a second value"),
    # --- search
    Mutation("search: closes dearer ways only", BEST, "known is not None and (known <= child_cost",
             "known is not None and (True", BRUTE),
    Mutation("search: lower bound is the cost", BEST, "return min(cost, min(waiting, default=cost))", "return cost",
             BRUTE),
    Mutation("search: optimal after a cut", BEST, "bound >= cost - EQUAL and not self.cut", "True", BRUTE),
    Mutation("search: exhausted told as infeasible", BEST,
             'search.status = Status.EXHAUSTED if self.cut else Status.INFEASIBLE',
             'search.status = Status.INFEASIBLE', SEARCH),
    Mutation("search: the empty plan again and again", BEST, "if self.no_goods.forbids_all:", "if False:", BRUTE),
    Mutation("search: wastar's order told as astar's", BEST, '{"astar": 1.0,', '{"astar": HURRIED,', BRUTE),
    Mutation("search: costs left out", BEST, "child_cost = cost + action_cost(action)", "child_cost = cost + 1.0",
             BRUTE),
    Mutation("search: own cost with surcharges", BEST, "cost = sum(search.successors.cost(n) for n in numbers)", "pass",
             (*SEARCH, *PENALTY)),
    Mutation("no-goods: prefixes end nowhere", NOGOODS, "self._tree[node][numbers[-1]] = LEAF", "pass", SEARCH),
    Mutation("no-goods: ends of all modules alike", f"{CONFLICTS}/lifting.py", "if module in self.reversible else end",
             "if True else end",
             (*SEARCH, *CLAIMS), "no model of the suite has ends that differ"),
    # --- slack maximisation and learned penalties
    Mutation("slack: gives back its input", ROOMY, "    if not ends or", "    if True or", SLACK),
    Mutation("slack: width 1", f"{SEARCHES}/settings.py", "        400, \"states\"", "        1, \"states\"", SLACK),
    Mutation("slack: flags need not agree", ROOMY, "following & flags != state & flags or ", "", SLACK),
    Mutation("slack: rules need not agree", ROOMY, " or successors.action(action).rule != wanted", "", SLACK),
    Mutation("slack: costs may grow", ROOMY, "> candidate.cost + EQUAL", "> candidate.cost + 10.0", SLACK),
    Mutation("slack: most strained first", ROOMY, "key=lambda n: n.strain", "key=lambda n: -n.strain", SLACK),
    Mutation("slack: what is forbidden is taken", NOGOODS, "return None if following is None or then is None else",
             "return", SLACK),
    Mutation("penalty: nothing forgotten", f"{SEARCHES}/settings.py", "limit_forgetting: float = setting(0.9",
             "limit_forgetting: float = setting(0.0", PENALTY),
    Mutation("penalty: weights never fade", SURCHARGE, "SEARCH.penalty_fading * other.weight",
             "other.weight", PENALTY),
    Mutation("penalty: does not grow", SURCHARGE, "self.weight * SEARCH.penalty_growth", "self.weight", PENALTY),
    Mutation("penalty: single actions too", SURCHARGE, "if first == last or ", "if ", PENALTY),
    Mutation("penalty: small strains too", SURCHARGE, " or strains[worst] < SEARCH.strained_from", "", PENALTY),
    # --- claims of the loop
    Mutation("gap always 0", LGP, "max(0.0, cost - self.first_bound)", "0.0", CLAIMS),
    Mutation("optimal whatever the gap", LGP, "optimal=gap == 0.0,\n            gap=gap",
             "optimal=True,\n            gap=gap", CLAIMS),
    Mutation("bound of the last candidate", LGP, "if self.first_bound is None:", "if True:", CLAIMS),
    Mutation("explanation the other way round", REFUSALS, "(min(map(_length, g)), -len(g))",
             "(-min(map(_length, g)), len(g))", CLAIMS),
    Mutation("explanation: seldom first", REFUSALS, ", -len(g))", ", len(g))", CLAIMS),
    Mutation("explanation: the largest miss", REFUSALS, "min(group, key=_miss)", "max(group, key=_miss)", CLAIMS),
    Mutation("explanation: causes of a rule as one", REFUSALS, "else worst.kind)", "else 0)", CLAIMS),
    Mutation("one failure blames a phase anywhere", "runtime/planner/bounds/settings.py", "3, \"pairs of poses\"",
             "1, \"pairs of poses\"", CLAIMS),
    Mutation("any failure blames a phase anywhere", JUDGED, "set.intersection(*blamed)", "set.union(*blamed)", CLAIMS),
    Mutation("the first phase blamed anywhere", JUDGED, "if worst in always and worst > 0:", "if worst in always:",
             CLAIMS),
    Mutation("less strained is expected to be refused", EXPERIENCE, "all(a >= b - ", "all(a <= b + ", CLAIMS),
    Mutation("success forgets the most strained", EXPERIENCE, "max(self._accepted.get(kind, 0.0), strain)", "strain",
             CLAIMS),
    Mutation("refusals of the start stay", EXPERIENCE, "if not key[1]}", "if True}", CLAIMS),
    Mutation("seeds: children are their parents", SEED, "spawn_key=self.way", "spawn_key=()", SEEDS),
    Mutation("seeds: the root is lost", SEED, "SeedSequence(self.root,", "SeedSequence(0,", SEEDS),
    # --- verifier
    Mutation("verifier keeps the shallowest", FOUND, "amount * worst.limit > worst.amount * limit",
             "amount * worst.limit < worst.amount * limit", LIMITS),
    Mutation("verifier: rates by amount", FOUND, "amount * worst.limit > worst.amount * limit",
             "amount > worst.amount", LIMITS),
    Mutation("verifier: what is no number passes", FOUND, "if math.isfinite(amount) else UNMEASURABLE",
             "if math.isfinite(amount) else 0.0", LIMITS),
    Mutation("verifier: rates 1 % above", TABLE, "RATE_SLACK = 1.001", "RATE_SLACK = 1.01", LIMITS),
    Mutation("verifier: penetration 2 mm", TABLE, '"penetration_m": 1e-3', '"penetration_m": 2e-3', LIMITS),
    Mutation("verifier skips speed between knots", RATE, "        if len(turns):", "        if False:", RATES),
    Mutation("verifier: acceleration not asked", RATE,
             '_record(problem, module, "acceleration", curve(knots, 2), knots, findings)', "pass", RATES),
    Mutation("verifier keeps the shallowest depth", DEPTH, "self.worst = max(self.worst", "self.worst = min(self.worst",
             (*TAMPER, *MEASURES)),
    # --- motion and run
    Mutation("late collisions not told", CLEAR, "        return broken\n", "        return False\n", NEARBY,
             "no unit test of it: what a solve misses so, the swept check refuses, and another start follows"),
    Mutation("a dearer clean path replaces a cheaper one", ATTEMPTS, "or cost[row] < group.cost[phase]:", "or True:",
             PATHS[:1]),
    Mutation("smoothing never gives up", f"{MOTION}/phases/settings.py", "        0.03, \"m\"", "        1e9, \"m\"",
             PATHS,
             "it costs time only: what is stuck is left in the end"),
    Mutation("bend never seen in sensing", SENSE, "> SIMULATION.sure * self.sigma * np.sqrt(inverse[2, 2]):", "> 1e9:",
             SENSING,
             "a look that is off the way tells a turn as soon, with the noise of the tests"),
    # --- figures of the report
    Mutation("report: metres told as centimetres", VIEW, "amount * 1000.0, small", "amount * 100.0, small", FIGURES),
    Mutation("report: a small figure told as none", VIEW, "0.0 < abs(amount) < least", "False", FIGURES),
    Mutation("report: share of the limit turned over", VIEW, "max(0.0, r.amount) / r.limit if",
             "r.limit / max(1e-9, r.amount) if", FIGURES),
    Mutation("report: least share called the worst", VIEW, "worst = max(known, default",
             "worst = min(known, default", FIGURES),
    Mutation("report: the first window counts as latency", VIEW, "plan.timing.windows[1:]", "plan.timing.windows[0:]",
             FIGURES),
    Mutation("report: mean told as greatest latency", VIEW, "max(seconds))", "sum(seconds) / len(seconds))", FIGURES),
    Mutation("report: shares of stages of each other", VIEW, "100.0 * value / whole",
             "100.0 * value / max(seconds.values())", FIGURES),
    Mutation("report: a gap told as optimal", VIEW, "    if statistics.optimal:", "    if statistics.gap is not None:",
             FIGURES),
    Mutation("report: motion ends with its first phase", LINE, "*(p.end for p in plan.phases)])",
             "*(p.end for p in plan.phases[:1])])", FIGURES),
    Mutation("report: blocks begin where phases end", LINE, "            phase.start * scale,\n            max(0.0",
             "            phase.end * scale,\n            max(0.0", FIGURES),
    Mutation("report: largest joint value without its sign", LINE, "values[int(np.argmax(np.abs(values)))]",
             "values[int(np.argmax(values))]", FIGURES),
    Mutation("report: limits drawn upside down", LINE, "100.0 * (high - value)", "100.0 * (value - low)", FIGURES),
    Mutation("report: nodes below counted once more", TREE, "above.below += 1", "above.below += 2", FIGURES),
]
