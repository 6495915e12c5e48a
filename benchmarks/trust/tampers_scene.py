"""Changes of what is in the scene, of the sources, and of what happens meanwhile."""

from __future__ import annotations

import base64
import hashlib
import re

from .draft import Draft
from .kinds import kind, need


@kind(false=True)
def body_moved(draft: Draft) -> None:
    body = draft.body()
    by = draft.chance.choice([1e-3, 0.02, -0.3])
    axis = draft.chance.randrange(3)
    body["pose"][axis] += by
    for track in draft.data["body_tracks"]:
        if track["name"] == body["name"]:
            for pose in track["poses"]:
                pose[axis] += by


@kind(false=True)
def body_turned(draft: Draft) -> None:
    draft.body()["pose"][3:] = [0.0, 0.0, 0.0998334166, 0.9950041653]


@kind(false=True)
def body_shrunk(draft: Draft) -> None:
    shape = draft.body()["shape"]
    shape["size"] = [0.9 * v for v in shape["size"]]


@kind(false=True)
def body_of_another_shape(draft: Draft) -> None:
    draft.body()["shape"].update(kind="sphere", size=[0.001])


@kind(false=True)
def body_gone(draft: Draft) -> None:
    body = draft.body()
    draft.data["bodies"].remove(body)
    draft.data["body_tracks"] = [t for t in draft.data["body_tracks"] if t["name"] != body["name"]]


@kind(false=True)
def body_more(draft: Draft) -> None:
    body = dict(draft.body())
    draft.data["bodies"].append({**body, "name": draft.chance.choice(["more", body["name"]])})


@kind(false=True)
def body_of_another_type(draft: Draft) -> None:
    body = draft.body()
    body["type"] = "object" if body["type"] != "object" else "effector"


@kind(false=True)
def movable_swapped(draft: Draft) -> None:
    body = draft.body()
    body["movable"] = not body["movable"]


@kind(false=True)
def link_missing(draft: Draft) -> None:
    links = draft.chance.choice(draft.data["modules"])["links"]
    need(links)
    del links[draft.chance.randrange(len(links))]


@kind(false=True)
def link_thinner(draft: Draft) -> None:
    links = draft.chance.choice(draft.data["modules"])["links"]
    need(links)
    size = draft.chance.choice(links)["shape"]["size"]
    size[0] *= draft.chance.choice([0.99, 0.5, 0.01])


@kind(false=True)
def effector_moved(draft: Draft) -> None:
    effectors = draft.chance.choice(draft.data["modules"])["effectors"]
    draft.chance.choice(effectors)["placement"][draft.chance.randrange(3)] += draft.chance.choice([1e-3, 0.05])


@kind(false=True)
def effector_without_shape(draft: Draft) -> None:
    found = [e for m in draft.data["modules"] for e in m["effectors"] if e["shape"] is not None]
    draft.chance.choice(found)["shape"] = None


@kind(false=True)
def joint_freer(draft: Draft) -> None:
    joints = draft.chance.choice([m for m in draft.data["modules"] if m["joints"]])["joints"]
    joint = draft.chance.choice(joints)
    field = draft.chance.choice(["lower", "upper", "speed", "acceleration"])
    joint[field] *= draft.chance.choice([1.01, 2.0, 100.0])


@kind(false=True)
def joint_elsewhere(draft: Draft) -> None:
    joints = draft.chance.choice([m for m in draft.data["modules"] if m["joints"]])["joints"]
    joint = draft.chance.choice(joints)
    if draft.chance.random() < 0.5:
        joint["axis"] = [-v for v in joint["axis"]]
    else:
        joint["placement"][2] += 0.01


@kind(false=True)
def joint_under_another_parent(draft: Draft) -> None:
    module = draft.chance.choice([m for m in draft.data["modules"] if len(m["joints"]) > 1])
    joint = draft.chance.choice(module["joints"][1:])
    joint["parent"] = draft.chance.choice([p for p in (-2, -1, len(module["joints"]), 10**6) if p != joint["parent"]])


@kind(false=True)
def start_elsewhere(draft: Draft) -> None:
    module = draft.chance.choice([m for m in draft.data["modules"] if m["joints"]])
    module["start"][draft.chance.randrange(len(module["start"]))] += 0.01


@kind(false=True)
def modules_swapped(draft: Draft) -> None:
    names = [m["name"] for m in draft.data["modules"]]
    need(len(names) > 1)
    one, other = draft.chance.sample(names, 2)
    exchanged = {one: other, other: one}
    for record in [*draft.data["modules"], *draft.data["tracks"]]:
        record["name"] = exchanged.get(record["name"], record["name"])
    for spline in draft.data["splines"]:
        spline["module"] = exchanged.get(spline["module"], spline["module"])


@kind(false=True)
def module_renamed(draft: Draft) -> None:
    draft.data["modules"][0]["name"] = draft.data["tracks"][0]["name"] = "stranger"


@kind(false=True)
def module_of_another_type(draft: Draft) -> None:
    draft.data["modules"][0]["type"] = "module"


# --- sources -----------------------------------------------------------------------------------------------------


def _rewrite(draft: Draft, path: str, pattern: str, to: str) -> None:
    """Another text with a hash that fits it."""
    source = next((s for s in draft.data["task"]["sources"] if s["path"].endswith(path)), None)
    need(source is not None)
    assert source is not None
    text, count = re.subn(pattern, to, source["text"], count=1)
    need(count)
    source["text"], source["sha256"] = text, hashlib.sha256(text.encode()).hexdigest()


def _main(draft: Draft) -> str:
    return str(draft.data["task"]["sources"][0]["path"])


@kind(false=True)
def text_changed(draft: Draft) -> None:
    source = draft.chance.choice(draft.data["task"]["sources"])
    source["text"] += " "


@kind(false=True)
def hash_changed(draft: Draft) -> None:
    source = draft.chance.choice(draft.data["task"]["sources"])
    source["sha256"] = source["sha256"][:-1] + ("0" if source["sha256"][-1] != "0" else "1")


@kind()
def comment_changed(draft: Draft) -> None:
    _rewrite(draft, _main(draft), r"\A", "# Changed, and hashed anew.\n")


@kind()
def scene_changed_and_hashed(draft: Draft) -> None:
    _rewrite(draft, _main(draft), r"box\(", "box(0.01 m + ")


@kind(false=True)
def capsules_thinner_and_hashed(draft: Draft) -> None:
    _rewrite(draft, "crawler.tamp", r"capsule\(0.04 m\)", "capsule(0.03 m)")


@kind(false=True)
def rule_changed_and_hashed(draft: Draft) -> None:
    """A rule that the plan uses has another effect."""
    rule = draft.chance.choice([p["rule"] for p in draft.phases])
    _rewrite(draft, "rules.tamp", rf"(rule {rule}\((?:.|\n)*?post  )", r"\1(moved c.A), ")


@kind(false=True)
def text_broken_and_hashed(draft: Draft) -> None:
    _rewrite(draft, _main(draft), r"(?m)^task\b", "tsak")


@kind(false=True)
def goal_told_otherwise(draft: Draft) -> None:
    draft.data["task"]["goal"] = draft.chance.choice(["", "(held nothing)", draft.data["task"]["goal"] + " or (a)"])


@kind(false=True)
def source_twice(draft: Draft) -> None:
    sources = draft.data["task"]["sources"]
    source = dict(draft.chance.choice(sources))
    source["text"] += "\n"
    source["sha256"] = hashlib.sha256(source["text"].encode()).hexdigest()
    sources.insert(draft.chance.choice([len(sources), 1]), source)


@kind(false=True)
def source_missing(draft: Draft) -> None:
    sources = draft.data["task"]["sources"]
    need(len(sources) > 1)
    del sources[draft.chance.randrange(1, len(sources))]


@kind(false=True)
def source_that_nothing_names(draft: Draft) -> None:
    text = "type strange < object\n"
    entry = {"path": "strange.tamp", "text": text, "sha256": hashlib.sha256(text.encode()).hexdigest()}
    draft.data["task"]["sources"].append(entry)


def _file(draft: Draft) -> dict[str, str]:
    """A URDF or mesh that the plan carries."""
    need(draft.data["task"].get("files"))
    found: dict[str, str] = draft.chance.choice(draft.data["task"]["files"])
    return found


@kind(false=True)
def file_changed(draft: Draft) -> None:
    entry = _file(draft)
    entry["data"] = base64.b64encode(base64.b64decode(entry["data"]) + b" ").decode()


@kind(false=True)
def file_changed_and_hashed(draft: Draft) -> None:
    entry = _file(draft)
    data = base64.b64decode(entry["data"])
    changed = re.sub(rb'(<origin xyz="[-0-9. ]*) ([-0-9.]+)"', rb'\1 9\2"', data, count=1)
    need(changed != data)
    entry["data"], entry["sha256"] = base64.b64encode(changed).decode(), hashlib.sha256(changed).hexdigest()


@kind(false=True)
def file_of_no_bytes(draft: Draft) -> None:
    _file(draft)["data"] = draft.chance.choice(["", "@@@", "AAA"])


@kind(false=True)
def file_missing(draft: Draft) -> None:
    draft.data["task"]["files"].remove(_file(draft))


@kind(false=True)
def file_that_nothing_names(draft: Draft) -> None:
    made = {"path": "strange.urdf", "data": "AAAA", "sha256": hashlib.sha256(b"\0\0\0").hexdigest()}
    draft.data["task"]["files"] = [*draft.data["task"].get("files", []), made]


@kind(false=True)
def task_of_another_name(draft: Draft) -> None:
    draft.data["task"]["name"] = draft.chance.choice(["", "other", "climbing", "leaving_modul"])


@kind(false=True)
def task_of_another_file(draft: Draft) -> None:
    draft.data["task"]["file"] = draft.chance.choice(["/etc/passwd", "std/rules.tamp", "other.tamp"])


@kind()
def parameter_changed(draft: Draft) -> None:
    parameters = draft.data["task"]["parameters"]
    need(parameters)
    name = draft.chance.choice(sorted(parameters))
    parameters[name] = parameters[name] + 1 if isinstance(parameters[name], int) else parameters[name] * 1.01 + 0.001


@kind(false=True)
def parameter_missing(draft: Draft) -> None:
    parameters = draft.data["task"]["parameters"]
    need(parameters)
    del parameters[draft.chance.choice(sorted(parameters))]


@kind(false=True)
def parameter_more(draft: Draft) -> None:
    draft.data["task"]["parameters"]["gravity"] = draft.chance.choice([1, 0.5])


@kind()
def seed_changed(draft: Draft) -> None:
    draft.data["task"]["seed"] = draft.chance.choice([1, 2, -1, 10**30])


# --- what happens meanwhile --------------------------------------------------------------------------------------


@kind()
def courses_missing(draft: Draft) -> None:
    need(draft.data.get("courses"))
    draft.data["courses"] = []


@kind(false=True)
def course_changed(draft: Draft) -> None:
    need(draft.data.get("courses"))
    course = draft.chance.choice(draft.data["courses"])
    if draft.chance.random() < 0.5:
        course["speed"] *= 1.1
    else:
        course["points"][-1][2] += 0.01


@kind()
def breakdowns_missing(draft: Draft) -> None:
    need(draft.data.get("breakdowns"))
    draft.data["breakdowns"] = []


@kind(false=True)
def breakdown_changed(draft: Draft) -> None:
    need(draft.data.get("breakdowns"))
    failed = draft.data["breakdowns"][0]
    match draft.chance.randrange(3):
        case 0:
            failed["time"] += draft.chance.choice([-0.1, 0.1, 1.0])
        case 1:
            failed["kind"] = "gone" if failed["kind"] == "locked" else "locked"
        case _:
            others = [m["name"] for m in draft.data["modules"] if m["name"] != failed["module"]]
            need(others)
            failed["module"] = others[0]


@kind(false=True)
def breakdown_invented(draft: Draft) -> None:
    """A module that is said to be gone collides with nothing."""
    module = draft.chance.choice(draft.data["modules"])["name"]
    made = {"module": module, "time": draft.chance.choice([0.0, 0.1]), "kind": "gone"}
    draft.data["breakdowns"] = [*draft.data.get("breakdowns", []), made]


@kind(false=True)
def window_outside(draft: Draft) -> None:
    need(draft.data.get("windows"))
    draft.chance.choice(draft.data["windows"])["phase"] = draft.chance.choice([-1, len(draft.phases) + 1, 10**9])


@kind(false=True)
def window_at_another_time(draft: Draft) -> None:
    need(draft.data.get("windows"))
    draft.chance.choice(draft.data["windows"])["time"] = draft.chance.choice([-1.0, 1e6])


@kind(false=True)
def unfinished_called_complete(draft: Draft) -> None:
    need(draft.data.get("complete") is False)
    draft.data["complete"] = True


@kind()
def complete_called_unfinished(draft: Draft) -> None:
    need(draft.data.get("complete", True))
    draft.data["complete"] = False
