"""What MuJoCo compiled as modules and bodies: trees of bodies that have joints are modules, all others bodies."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from ...langs.frozen import dataclass
from ..ir import IDENTITY, Pose, Vec3
from ..poses import about, compose, make
from .models import (
    FAR,
    STRAIGHT,
    Form,
    Hinge,
    Models,
    PartWeight,
    RobotModel,
    RobotPart,
    Thing,
    ball,
    linked,
    plain_ends,
)
from .names import STANDARD, GivenNames

if TYPE_CHECKING:
    from .mjcf import Reader

FREE, BALL, SLIDE, HINGE = range(4)
PLANE, FIELD, SPHERE, CAPSULE, ELLIPSOID, CYLINDER, BOX, MESH = range(8)
AXES: tuple[Vec3, ...] = ((0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0))
FIELDS = (
    "body_parentid", "body_pos", "body_quat", "body_mass", "body_ipos", "body_iquat", "body_inertia", "body_jntadr",
    "body_jntnum", "body_geomadr", "body_geomnum", "jnt_type", "jnt_pos", "jnt_axis", "jnt_range", "jnt_limited",
    "jnt_qposadr", "jnt_actfrclimited", "jnt_actfrcrange", "qpos0", "geom_type", "geom_pos", "geom_quat", "geom_size",
    "geom_contype", "geom_conaffinity", "geom_dataid", "mesh_vert", "mesh_vertadr", "mesh_vertnum", "actuator_trnid",
    "actuator_gear", "actuator_forcelimited", "actuator_forcerange", "eq_type", "eq_obj1id", "eq_obj2id", "eq_data",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Compiled:
    """The arrays of a model, as lists, by their name in MuJoCo, and the names of bodies, joints and geoms."""

    values: dict[str, Any]
    bodies: tuple[str, ...]
    joints: tuple[str, ...]
    geoms: tuple[str, ...]

    @classmethod
    def of(cls, mujoco: Any, model: Any) -> Compiled:
        """Of a compiled model."""
        kinds = mujoco.mjtObj
        pairs = ((kinds.mjOBJ_BODY, model.nbody), (kinds.mjOBJ_JOINT, model.njnt), (kinds.mjOBJ_GEOM, model.ngeom))
        names = [tuple(mujoco.mj_id2name(model, kind, i) or "" for i in range(count)) for kind, count in pairs]
        return cls({name: getattr(model, name).tolist() for name in FIELDS}, *names)

    def pose(self, what: str, index: int, prefix: str = "") -> Pose:
        """A pose, of which MuJoCo has the scalar of the quaternion first."""
        x, y, z = self.values[f"{what}_{prefix}pos"][index]
        w, i, j, k = self.values[f"{what}_{prefix}quat"][index]
        return make((x, y, z), (i, j, k, w))


def models_of(reader: Reader, compiled: Compiled) -> Models:
    """The modules and bodies of a model."""
    return _Builder(reader, compiled).build()


class _Builder:
    def __init__(self, reader: Reader, compiled: Compiled) -> None:
        self.reader, self.m, self.v = reader, compiled, compiled.values
        self.models, self.names = Models(), GivenNames(STANDARD)
        self.below: dict[int, list[int]] = {}
        for body, parent in enumerate(self.v["body_parentid"]):
            if body:
                self.below.setdefault(parent, []).append(body)

    def build(self) -> Models:
        self._things(0, IDENTITY)
        for body in self.below.get(0, ()):
            self._top(body, IDENTITY)
        return self.models

    def _top(self, body: int, frame: Pose) -> None:
        place = compose(frame, self.m.pose("body", body))
        tree = self._tree(body)
        joints = [j for b in tree for j in self._joints(b)]
        moving = [j for j in joints if self.v["jnt_type"][j] != FREE]
        if moving:
            self._robot(body, tree, place)
        elif joints:
            self._loose(body, tree, place)
        else:
            self._things(body, place)
            for other in self.below.get(body, ()):
                self._top(other, place)

    def _tree(self, body: int) -> list[int]:
        found = [body]
        for other in found:
            found += self.below.get(other, ())
        return found

    def _joints(self, body: int) -> range:
        first = self.v["body_jntadr"][body]
        return range(first, first + self.v["body_jntnum"][body])

    def _geoms(self, body: int) -> list[int]:
        """The geoms that others may hit."""
        first = self.v["body_geomadr"][body]
        every = range(first, first + self.v["body_geomnum"][body])
        return [g for g in every if self.v["geom_contype"][g] or self.v["geom_conaffinity"][g]]

    def _leave(self, kind: str, name: str, message: str) -> None:
        named = self.reader.named
        found = named.get((kind, name))
        if found is None:  # a copy that `replicate` made
            found = next((e for (k, n), e in named.items() if k == kind and name.startswith(n)), None)
        self.reader.leave(found if found is not None else self.reader.lines[0], message)

    def _things(self, body: int, frame: Pose) -> None:
        for geom in self._geoms(body):
            form = self._form(geom)
            if form is not None:
                turned = Form(form.kind, form.size, compose(frame, form.place))
                self.models.things.append(Thing("base", self.names.fresh(self.m.geoms[geom]), (turned,)))

    def _loose(self, top: int, tree: list[int], place: Pose) -> None:
        """A body that floats with all that is fixed to it, as one of several shapes."""
        frames, forms = {top: place}, []
        for body in tree:
            if body != top:
                frames[body] = compose(frames[self.v["body_parentid"][body]], self.m.pose("body", body))
            made = [form for form in map(self._form, self._geoms(body)) if form is not None]
            forms += [Form(form.kind, form.size, compose(frames[body], form.place)) for form in made]
        if forms:
            name = self.names.fresh(self.m.bodies[top])
            mass = sum(self.v["body_mass"][body] for body in tree)
            self.models.things.append(Thing("object", name, tuple(forms), mass))
            self.models.facts.append(f"(grippable {name})")

    def _robot(self, top: int, tree: list[int], place: Pose) -> None:
        name = self.names.fresh(self.m.bodies[top] or "robot")
        parts: list[RobotPart] = []
        hinges: list[Hinge] = []
        moved = [j for j in self._joints(top) if self.v["jnt_type"][j] != FREE]
        for joint in set(self._joints(top)) - set(moved):
            shown = self.m.joints[joint]
            self._leave("joint", shown, f"`{name}` floats by `{shown}`: it stands where the scene puts it instead")
        if moved:
            parts.append(RobotPart(f"{self.m.bodies[top]}_stand"))
        for body in tree:
            if body != top or moved:
                upper = parts[0].name if body == top else self.m.bodies[self.v["body_parentid"][body]]
                self._chain(body, upper, IDENTITY if body == top else self.m.pose("body", body), parts, hinges)
            parts.append(self._part(body))
        hinges = [self._coupled(h, {x.name for x in hinges}) for h in hinges]
        ends = plain_ends(GivenNames(), parts, hinges)
        robot = RobotModel(name, tuple(parts), tuple(hinges), ends, linked(ends))
        fixed = len(moved) == len(self._joints(top))
        self.models.stand(robot, self.names.fresh(f"{name}_1"), place, fixed)

    def _chain(self, body: int, upper: str, frame: Pose, parts: list[RobotPart], hinges: list[Hinge]) -> None:
        """The joints of a body, one after the other, each about its own point."""
        own, pending = self.m.bodies[body], frame
        steps = [s for j in self._joints(body) for s in self._steps(j)]
        for index, (name, kind, at, axis, shift, lower, upper_limit) in enumerate(steps):
            last = index == len(steps) - 1 and at == (0.0, 0.0, 0.0)
            below = own if last else f"{own}_{name}"
            origin = compose(compose(pending, make(at, STRAIGHT)), shift)
            joint = name.rpartition(".")[0] or name
            effort = self._effort(joint)
            hinges.append(Hinge(name, kind, upper, below, origin, axis, lower, upper_limit, 0.0, effort))
            if not last:
                parts.append(RobotPart(below))
            upper, pending = below, make((-at[0], -at[1], -at[2]), STRAIGHT)
        if upper != own:
            hinges.append(Hinge(f"{own}_fixed", "fixed", upper, own, pending))

    def _steps(self, joint: int) -> list[tuple[str, str, Vec3, Vec3, Pose, float, float]]:
        """Joints of one degree that a joint is made of."""
        name, kind = self.m.joints[joint], self.v["jnt_type"][joint]
        if kind == FREE:
            self._leave("joint", name, f"joint `{name}` is free inside a module, and is held")
            return []
        x, y, z = self.v["jnt_pos"][joint]
        if kind == BALL:
            self._leave("joint", name, f"joint `{name}` is a ball, and becomes three joints, yaw, pitch and roll")
            shown = zip(("yaw", "pitch", "roll"), AXES, strict=True)
            return [(f"{name}.{n}", "revolute", (x, y, z), a, IDENTITY, -math.pi, math.pi) for n, a in shown]
        i, j, k = self.v["jnt_axis"][joint]
        if i == j == k == 0:
            self._leave("joint", name, f"the axis of joint `{name}` is no direction, and the joint is held")
            return []
        start = self.v["qpos0"][self.v["jnt_qposadr"][joint]]
        turn = make((0.0, 0.0, 0.0), about((i, j, k), -start))
        shift = turn if kind == HINGE else make((-start * i, -start * j, -start * k), STRAIGHT)
        shift = IDENTITY if start == 0 else shift
        lower, upper = self.v["jnt_range"][joint]
        word = "revolute" if kind == HINGE else "prismatic"
        if not self.v["jnt_limited"][joint]:
            word, lower, upper = ("continuous", 0.0, 0.0) if kind == HINGE else (word, start - FAR, start + FAR)
            if kind == SLIDE:
                self._leave("joint", name, f"joint `{name}` has no limits: it moves {FAR:g} m each way")
        return [(name, word, (x, y, z), (i, j, k), shift, lower, upper)]

    def _effort(self, name: str) -> float:
        joint = self.m.joints.index(name) if name in self.m.joints else -1
        if joint >= 0 and self.v["jnt_actfrclimited"][joint]:
            return float(max(map(abs, self.v["jnt_actfrcrange"][joint])))
        for k, (driven, _) in enumerate(self.v["actuator_trnid"]):
            if driven == joint and self.v["actuator_forcelimited"][k]:
                strongest = max(map(abs, self.v["actuator_forcerange"][k]))
                return float(abs(self.v["actuator_gear"][k][0]) * strongest)
        return 0.0

    def _coupled(self, hinge: Hinge, known: set[str]) -> Hinge:
        """With its leader, where an equality makes it follow one."""
        for k, kind in enumerate(self.v["eq_type"]):
            if kind != 2 or self.m.joints[self.v["eq_obj1id"][k]] != hinge.name or self.v["eq_obj2id"][k] < 0:
                continue
            leader, data = self.m.joints[self.v["eq_obj2id"][k]], self.v["eq_data"][k]
            if leader not in known or any(data[2:5]):
                message = f"joint `{hinge.name}` follows `{leader}` by a curve, or outside its module: it moves freely"
                self._leave("joint", hinge.name, message)
                continue
            starts = [self.v["qpos0"][self.v["jnt_qposadr"][self.m.joints.index(n)]] for n in (hinge.name, leader)]
            follows = (leader, data[1], starts[0] + data[0] - data[1] * starts[1])
            return replace(hinge, leader=follows)
        return hinge

    def _part(self, body: int) -> RobotPart:
        forms = [f for f in map(self._form, self._geoms(body)) if f is not None]
        mass, (a, b, c) = self.v["body_mass"][body], self.v["body_inertia"][body]
        weight = PartWeight(mass, self.m.pose("body", body, "i"), (a, 0.0, 0.0, b, 0.0, c)) if mass > 0 else None
        return RobotPart(self.m.bodies[body], tuple(forms), weight)

    def _form(self, geom: int) -> Form | None:
        kind, (a, b, c) = self.v["geom_type"][geom], self.v["geom_size"][geom]
        place, name = self.m.pose("geom", geom), self.m.geoms[geom]
        if kind == SPHERE:
            return Form("sphere", (a,), place)
        if kind in (CAPSULE, CYLINDER):
            return Form("capsule" if kind == CAPSULE else "cylinder", (a, 2 * b), place)
        if kind == BOX:
            return Form("box", (2 * a, 2 * b, 2 * c), place)
        if kind == PLANE:
            wide, deep = (2 * (s if 0 < s <= FAR else FAR) for s in (a, b))
            if not (0 < a <= FAR and 0 < b <= FAR):
                self._leave("geom", name, f"plane `{name}` becomes a plate of {wide:g} x {deep:g} m")
            return Form("box", (wide, deep, 0.1), compose(place, make((0.0, 0.0, -0.05), STRAIGHT)))
        if kind == ELLIPSOID:
            self._leave("geom", name, f"ellipsoid `{name}` becomes a body around it, of up to 1.3 times its volume")
            return self._convex(name, [[x * a, y * b, z * c] for x, y, z in ball()], place)
        if kind == MESH and self.v["geom_dataid"][geom] >= 0:
            mesh = self.v["geom_dataid"][geom]
            first = self.v["mesh_vertadr"][mesh]
            return self._convex(name, self.v["mesh_vert"][first : first + self.v["mesh_vertnum"][mesh]], place)
        self._leave("geom", name, f"geom `{name}` is of a kind without counterpart, and is left out")
        return None

    def _convex(self, name: str, points: list[list[float]], place: Pose) -> Form | None:
        from ..hulls import HullError, convex_shape

        try:
            shape, middle, simpler = convex_shape(points)
        except HullError as reason:
            self._leave("geom", name, f"geom `{name}` is left out: {reason}")
            return None
        if simpler:
            self._leave("geom", name, f"geom `{name}` becomes a body of few faces around its hull")
        return Form("convex", shape.size, compose(place, make(middle, STRAIGHT)))
