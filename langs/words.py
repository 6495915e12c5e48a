"""The words of the language, each with its group and a line of documentation: one list for hover, completion, colours
and editors. A test holds it to the grammar."""

from __future__ import annotations

from collections.abc import Mapping

from .frozen import dataclass


@dataclass(frozen=True, slots=True)
class Word:
    """`group` is one of declaration, part (it begins a statement inside a block), clause, modifier, control."""

    group: str
    doc: str


WORDS: Mapping[str, Word] = {
    "import": Word("declaration", "takes over what another file declares"),
    "type": Word("declaration", "declares a type of objects, below another one"),
    "predicate": Word("declaration", "declares a predicate that facts and rules speak of"),
    "derived": Word("declaration", "declares a predicate that follows from others"),
    "function": Word("declaration", "gives a value a name"),
    "module": Word("declaration", "declares a module type: effectors, joints and links; also the type of all modules"),
    "motion": Word("declaration", "declares what a motion literal asks of the motion"),
    "rule": Word("declaration", "declares a kind of action: conditions and effects"),
    "placement": Word("declaration", "says what holds at the start for what is put `on` something"),
    "heuristic": Word("declaration", "declares the estimated cost to the goal, and how actions change it"),
    "scene": Word("declaration", "declares bodies and robots; inside a scene or task, uses another scene"),
    "task": Word("declaration", "declares a scene with a goal, a guide and options"),
    "pre": Word("part", "conditions on the state under which the rule may fire"),
    "where": Word("part", "conditions on the geometry of the start under which the rule may fire"),
    "post": Word("part", "literals that the action adds, and with `not` deletes"),
    "cost": Word("part", "what the action costs; 1 unless given"),
    "goal": Word("part", "what must hold at the end"),
    "guide": Word("part", "names the heuristic that guides the search"),
    "fact": Word("part", "states what holds at the start"),
    "options": Word("part", "sets options of the planner for this task"),
    "minimise": Word("part", "what plans are to be best at, such as `makespan + 0.1 * travel`"),
    "start": Word("part", "the value of a heuristic at the start"),
    "effector": Word("part", "an end of a module, where it stands, grips or is docked; also the type of all of them"),
    "joint": Word("part", "a revolute, prismatic or planar joint of a module"),
    "link": Word("part", "goes on along the module by a length or a vector, with a shape in between"),
    "branch": Word("part", "what stands inside goes on from here, and what follows it from here again"),
    "moves": Word("part", "a body moves on its own while the plan is executed"),
    "disturb": Word("part", "a body jumps while the plan is executed"),
    "fail": Word("part", "a module breaks down while the plan is executed"),
    "during": Word("part", "a row that binds as long as the literal holds"),
    "keep": Word("part", "a value that stays constant as long as the literal holds"),
    "touching": Word("part", "two objects that may touch as long as the literal holds"),
    "at": Word("clause", "where something is put, or with `switch` a row that binds when the literal is added"),
    "switch": Word("clause", "the moment at which an action adds a literal"),
    "on": Word("clause", "what something stands on"),
    "heading": Word("clause", "turns a thing about the vertical"),
    "along": Word("clause", "the points through which a body moves"),
    "back": Word("clause", "the body moves back and forth for ever"),
    "normal": Word("clause", "the outward direction of an effector"),
    "home": Word("clause", "the value of a joint at the start"),
    "speed": Word("clause", "the greatest speed of a joint; also a type of values"),
    "acceleration": Word("clause", "the greatest acceleration of a joint"),
    "jerk": Word("clause", "the greatest jerk of a joint: how fast its acceleration may change; no limit unless given"),
    "from": Word("clause", "the file of a module from a URDF, or the time at which a body starts"),
    "urdf": Word("clause", "the description of a module as other tools write it"),
    "by": Word("clause", "the predicate that links the modules of a chain, or how far a body jumps"),
    "of": Word("clause", "the modules of a chain"),
    "chain": Word("clause", "maximal lines of modules that a predicate links, each from both its ends"),
    "in": Word("clause", "the values that a variable, parameter or joint may take"),
    "mass": Word("clause", "what a part or body weighs"),
    "density": Word("clause", "mass per volume, where no mass is given"),
    "torque": Word("clause", "the greatest torque of a joint that turns"),
    "force": Word("clause", "the greatest force of a joint that slides"),
    "bearing": Word("clause", "the greatest load that the bearing of a joint takes"),
    "rotor": Word("clause", "the inertia of a joint's motor as the joint feels it"),
    "brake": Word("clause", "the greatest torque or force that a joint bears while it does not move"),
    "holds": Word("clause", "how strongly an end or body holds, in a manner such as `pad` or `dock`"),
    "borne": Word("modifier", "the manner in which the pair of a motion predicate holds; `nothing` bears nothing"),
    "passive": Word("modifier", "the joint has no drive: it moves only while something driven holds it"),
    "static": Word("modifier", "no rule changes the predicate"),
    "symmetric": Word("modifier", "both orders of the arguments mean the same"),
    "functional": Word("modifier", "for each value of the parameter it holds at most once"),
    "if": Word("control", "chooses by a condition"),
    "then": Word("control", "the value where the condition holds"),
    "else": Word("control", "the value where the condition does not hold"),
    "for": Word("control", "repeats what stands inside"),
    "forall": Word("control", "holds when it holds for all values of the variables"),
    "exists": Word("control", "holds when it holds for some values of the variables"),
    "and": Word("control", "both hold"),
    "or": Word("control", "one of them holds, or both"),
    "not": Word("control", "does not hold; among effects, is deleted"),
    "previous": Word("control", "the action before the last, in a heuristic"),
    "is": Word("control", "behind `previous`: names its rule"),
    "ANY": Word("control", "fits everything; in conditions, deleted literals and behind `previous is`"),
    "min": Word("control", "the smaller of some values, or the smallest over all values of the variables"),
    "max": Word("control", "the larger of some values, or the largest over all values of the variables"),
    "sum": Word("control", "the sum over all values of the variables"),
}
RESERVED = ("and", "or", "not", "if", "then", "else", "exists", "forall", "ANY")
"""The words that are never names."""
UNITS = {
    "m": "length", "cm": "length", "mm": "length", "rad": "angle", "deg": "angle", "s": "time", "min": "time",
    "kg": "mass", "g": "mass", "N": "force", "kN": "force", "N m": "torque", "kN m": "torque",
    "kg/m^3": "density", "kg/m³": "density", "kg m^2": "inertia", "kg m²": "inertia",
}  # fmt: skip
TYPES: Mapping[str, str] = {
    "object": "anything with a pose and a shape",
    "region": "only a place: nothing collides with it",
    "effector": "an end of a module, where it stands, grips or is docked",
    "module": "a robot or a part of one, with joints, links and effectors",
    "int": "a whole number",
    "real": "a number",
    "length": "a length, in metres inside",
    "angle": "an angle, in radians inside",
    "time": "a time, in seconds inside",
    "speed": "a length per second",
    "mass": "a mass, in kilograms inside",
    "density": "a mass per volume",
    "force": "a force, in newtons inside",
    "torque": "a torque, in newton metres inside",
    "inertia": "a moment of inertia",
}
SHAPES: Mapping[str, str] = {
    "box": "box(x, y, z): a box with these sides",
    "sphere": "sphere(r): a ball of radius r",
    "capsule": "capsule(r, length): a cylinder with round ends; along a link, capsule(r)",
    "cylinder": "cylinder(r, length): an upright cylinder",
    "hull": 'hull((x, y, z), …) of four corners or more, or hull("FILE") of a mesh',
    "mesh": 'mesh("FILE", unit): a mesh from a file, cut into convex parts',
    "union": "union(box(…) at (x, y, z), …): a body of several shapes",
}
JOINTS: Mapping[str, str] = {
    "revolute": "revolute(axis): turns about x, y or z",
    "prismatic": "prismatic(axis): slides along x, y or z",
    "planar": "planar(x, y): slides along x and y and turns about z",
}
ATTRIBUTES: Mapping[str, str] = {
    "first": "the outer effector at which a chain begins",
    "last": "the outer effector at which a chain ends",
    "in": "the effector by which the chain enters this module",
    "out": "the effector by which the chain leaves this module",
}
