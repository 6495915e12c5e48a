"""Changes of the actions, the phases, and the literals that hold."""

from __future__ import annotations

import copy
from typing import Any

from .draft import Draft
from .kinds import kind, need


def _done(draft: Draft) -> dict[str, Any]:
    found = [p for p in draft.phases if p.get("completed", True)]
    need(found)
    chosen: dict[str, Any] = draft.chance.choice(found)
    return chosen


def _drop(draft: Draft, field: str) -> None:
    found = [p for p in draft.phases if p[field]]
    need(found)
    literals = draft.chance.choice(found)[field]
    del literals[draft.chance.randrange(len(literals))]


def _rename(phase: dict[str, Any]) -> None:
    phase["action"] = f"{phase['rule']}({', '.join(map(str, phase['args']))})"


@kind(false=True)
def last_phase_missing(draft: Draft) -> None:
    need(draft.data.get("complete", True) and len(draft.phases) > 1)
    draft.cut(len(draft.phases) - 1)


@kind()
def phase_missing(draft: Draft) -> None:
    need(len(draft.phases) > 1)
    draft.cut(draft.chance.randrange(len(draft.phases)))


@kind(false=True)
def record_of_a_phase_missing(draft: Draft) -> None:
    del draft.phases[draft.chance.randrange(len(draft.phases))]


@kind(false=True)
def phase_twice(draft: Draft) -> None:
    at = draft.chance.randrange(len(draft.phases))
    draft.phases.insert(at, copy.deepcopy(draft.phases[at]))


@kind(false=True)
def phases_in_another_order(draft: Draft) -> None:
    need(len(draft.phases) > 1)
    one, other = draft.chance.sample(range(len(draft.phases)), 2)
    draft.phases[one], draft.phases[other] = draft.phases[other], draft.phases[one]


@kind()
def actions_in_another_order(draft: Draft) -> None:
    need(len(draft.phases) > 1)
    one, other = draft.chance.sample(draft.phases, 2)
    for field in ("action", "rule", "args", "added", "completed"):
        one[field], other[field] = other.get(field, True), one.get(field, True)


@kind(false=True)
def argument_of_another_object(draft: Draft) -> None:
    phase = _done(draft)
    names = [b["name"] for b in draft.data["bodies"]]
    names += [f"{m['name']}.{e['name']}" for m in draft.data["modules"] for e in m["effectors"]]
    at = draft.chance.randrange(len(phase["args"]))
    phase["args"][at] = draft.chance.choice([n for n in names if n != phase["args"][at]])
    _rename(phase)


@kind(false=True)
def argument_too_many(draft: Draft) -> None:
    phase = _done(draft)
    phase["args"].append(phase["args"][0])
    _rename(phase)


@kind(false=True)
def argument_of_no_kind(draft: Draft) -> None:
    phase = _done(draft)
    phase["args"][0] = draft.chance.choice(["", "[]", "[a b", "nobody", 7, None, ["c", "d"], "[" * 2000])
    _rename(phase)


@kind(false=True)
def another_rule(draft: Draft) -> None:
    phase = _done(draft)
    phase["rule"] = draft.chance.choice(["fly", "", "climb"])
    _rename(phase)


@kind(false=True)
def action_told_otherwise(draft: Draft) -> None:
    phase = _done(draft)
    phase["action"] = draft.chance.choice(["rest()", phase["action"].replace("(", "(x, "), ""])


@kind(false=True)
def fact_missing(draft: Draft) -> None:
    _drop(draft, "literals")


@kind(false=True)
def fact_more(draft: Draft) -> None:
    found = [p for p in draft.phases if p["literals"]]
    need(found)
    literals = draft.chance.choice(found)["literals"]
    made = copy.deepcopy(draft.chance.choice(literals))
    made["args"][-1] = "nobody"
    literals.append(made)


@kind(false=True)
def mode_lacks_a_literal(draft: Draft) -> None:
    _drop(draft, "mode")


@kind(false=True)
def mode_has_one_more(draft: Draft) -> None:
    phases = [k for k, p in enumerate(draft.phases) if p["added"]]
    need(phases)
    at = draft.chance.choice(phases)
    draft.phases[at]["mode"].append(copy.deepcopy(draft.phases[at]["added"][0]))


@kind()
def added_lacks_a_literal(draft: Draft) -> None:
    _drop(draft, "added")


@kind()
def nothing_is_added(draft: Draft) -> None:
    found = [p for p in draft.phases if p["added"]]
    need(found)
    draft.chance.choice(found)["added"] = []


@kind(false=True)
def added_has_one_more(draft: Draft) -> None:
    found = [p for p in draft.phases if p["mode"] and p["added"]]
    need(found)
    phase = draft.chance.choice(found)
    made = copy.deepcopy(phase["added"][0])
    made["args"] = [made["args"][0], f"{draft.data['modules'][0]['name']}.nobody"]
    phase["added"].append(made)


@kind(false=True)
def a_literal_of_another_thing(draft: Draft) -> None:
    found = [p for p in draft.phases if p["mode"]]
    need(found)
    literal = draft.chance.choice(draft.chance.choice(found)["mode"])
    literal["args"] = literal["args"][::-1]
    need(literal["args"][0] != literal["args"][-1] and not draft.problem.motions[literal["predicate"]].symmetric)


@kind(false=True)
def final_mode_lacks_a_literal(draft: Draft) -> None:
    need(draft.data["final_mode"])
    del draft.data["final_mode"][draft.chance.randrange(len(draft.data["final_mode"]))]


@kind(false=True)
def final_mode_has_one_more(draft: Draft) -> None:
    need(draft.data["final_mode"])
    made = copy.deepcopy(draft.data["final_mode"][0])
    made["args"][-1] = "nobody"
    draft.data["final_mode"].append(made)


@kind(false=True)
def done_called_not_completed(draft: Draft) -> None:
    """The action, which changes something, did not take place; yet its effects hold from then on."""
    _done(draft)["completed"] = False


@kind()
def broken_off_called_completed(draft: Draft) -> None:
    found = [p for p in draft.phases if not p.get("completed", True)]
    need(found)
    draft.chance.choice(found)["completed"] = True


@kind(false=True)
def effects_of_what_was_broken_off(draft: Draft) -> None:
    found = [p for p in draft.phases if not p.get("completed", True)]
    done = [p for p in draft.phases if p["added"]]
    need(found and done)
    draft.chance.choice(found)["added"] = copy.deepcopy(done[0]["added"])


@kind()
def place_told_otherwise(draft: Draft) -> None:
    found = [p for p in draft.phases if p["mode"] and p["mode"][0].get("place")]
    need(found)
    draft.chance.choice(found)["mode"][0]["place"]["line"] += 1
