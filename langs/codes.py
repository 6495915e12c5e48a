"""Every code of the project, with what it means; programs that show each lie in `explanations/`.

One flat table in the order of the codes: E00 text and syntax, E01 names and imports, E02 types and units, E03 logic,
E04 motion constraints, E05 scenes and tasks, W warnings, S outcomes of the solver.
"""

from __future__ import annotations

from .diagnostics import did_you_mean
from .explanation import CodeInfo

CODES: dict[str, CodeInfo] = {
    "E0001": CodeInfo("unexpected text", "syntax",
        "The text does not follow the grammar at this place; the message says what may stand here."),
    "E0002": CodeInfo("unknown character", "syntax",
        "This character has no meaning in the language outside comments and quoted texts."),
    "E0003": CodeInfo("missing punctuation", "syntax",
        "One sign is lacking, such as a colon, a comma or a parenthesis; with it the rest can be read."),
    "E0004": CodeInfo("misspelt keyword", "syntax",
        "A word stands where only a keyword of the language can."),
    "E0005": CodeInfo("missing closing bracket", "syntax",
        "A brace, bracket or parenthesis is opened and never closed."),
    "E0006": CodeInfo("unfinished text", "syntax",
        "A quoted text ends on the line where it starts."),
    "E0007": CodeInfo("unknown unit", "syntax",
        "Units are m, cm, mm for lengths, rad, deg for angles, s, min for times, and a length or angle per "
        "second, such as rad/s, for speeds, per second squared for accelerations, and per s^3 for jerks."),
    "E0008": CodeInfo("nested too deeply", "syntax",
        "Brackets, operators or imports are nested more than 100 deep, or what a function, derived predicate or scene "
        "stands for is, once what it uses is put in."),
    "E0009": CodeInfo("number out of range", "syntax",
        "A number must be finite in double precision, also one that is computed; lengths in scenes are at most 1000 "
        "km."),
    "E0010": CodeInfo("file not found", "file", "There is no file of this name."),
    "E0011": CodeInfo("unreadable file", "file", "The operating system refuses to give the contents of the file."),
    "E0012": CodeInfo("not a file", "file", "A source is a file of text, not a directory or a device."),
    "E0013": CodeInfo("empty file", "file", "The file holds no text."),
    "E0014": CodeInfo("not text", "file", "A source is text in UTF-8; this file holds other bytes."),
    "E0015": CodeInfo("file too large", "file", "A source holds at most 1 MB. Use loops for scenes of many bodies."),
    "E0016": CodeInfo("condition and value confused", "syntax",
        "Literals and comparisons are conditions; numbers, names and functions are values."),
    "E0017": CodeInfo("range without end", "syntax",
        "A range has two ends. What counts the modules of a chain ends with its length."),
    "E0018": CodeInfo("plan instead of program", "file",
        "`tamplang verify` checks a plan file and `tamplang report` draws it; `check` and `solve` read programs."),
    "E0019": CodeInfo("broken file of others", "file",
        "A file that is imported does not follow the syntax of its own format at this place, such as a bracket that is "
        "never closed. Nothing is written."),
    "E0020": CodeInfo("no counterpart", "file",
        "A file that is imported says what this language cannot say, so that its meaning would be lost. Nothing is "
        "written. docs/imports.md tells what each format may hold."),
    "E0021": CodeInfo("file of others", "file",
        "The file belongs to another tool. The hint says which command reads it, or what is to be made of it first."),
    "E0022": CodeInfo("mistake in a file of others", "file",
        "A file that is imported uses what it does not declare, declares something twice, or contradicts itself. "
        "Nothing is written."),
    "E0023": CodeInfo("no readable plan", "file",
        "A plan file is read as a whole or not at all: what is cut off, has fields that the format does not know or "
        "lacks some, says that it has another format than it has, or has splines of both formats is no plan. "
        "docs/plan-format.md tells what a file holds. What can be read but is not true is refused (S0004)."),
    "E0101": CodeInfo("unknown name", "name",
        "No variable, parameter or object of this name can be seen here."),
    "E0102": CodeInfo("unknown type", "name",
        "Types are declared by `type` or `module`; object, effector, module and the value types int, real, "
        "length, angle, time, speed are built in."),
    "E0103": CodeInfo("unknown predicate", "name",
        "Literals in parentheses name a predicate declared by `predicate` or `derived`, here or in an "
        "imported file."),
    "E0104": CodeInfo("unknown motion predicate", "name",
        "Literals in square brackets name a predicate declared by `motion`."),
    "E0105": CodeInfo("unknown rule", "name",
        "Heuristics speak of rules that are declared here or imported."),
    "E0106": CodeInfo("unknown heuristic", "name",
        "`guide` names a heuristic."),
    "E0107": CodeInfo("unknown scene", "name",
        "`scene` in a task names a scene."),
    "E0108": CodeInfo("unknown module type", "name",
        "Only a type declared by `module` can be put into a scene as a robot."),
    "E0109": CodeInfo("unknown function", "name",
        "The functions of the language are listed in docs/language.md."),
    "E0110": CodeInfo("duplicate declaration", "name",
        "A name is declared once in a file and all that it imports."),
    "E0111": CodeInfo("import not found", "name",
        '`import std.NAME` reads the standard library, `import "PATH"` a file beside the importing one.'),
    "E0112": CodeInfo("import cycle", "name",
        "Files import each other in a ring. Move what both need into a third file."),
    "E0113": CodeInfo("unknown task", "name", "The file declares no task of this name."),
    "E0114": CodeInfo("unknown attribute", "name",
        "A chain has .first and .last, its k-th module c[k] has .in and .out, a module of a scene has its "
        "effectors."),
    "E0115": CodeInfo("type cycle", "name",
        "A type cannot be below itself."),
    "E0116": CodeInfo("unknown option", "name",
        "Options of a task are bound, search, time, nodes, solver, slices, margin."),
    "E0117": CodeInfo("unknown effector", "name",
        "The module type has no effector of this name."),
    "E0118": CodeInfo("reserved name", "name",
        "This name belongs to the language and cannot be declared again."),
    "E0119": CodeInfo("unknown joint", "name",
        "A joint follows another one of its module, which is called by its name."),
    "E0201": CodeInfo("wrong number of arguments", "type",
        "Predicates, functions and rules take as many arguments as they are declared with."),
    "E0202": CodeInfo("type mismatch", "type",
        "The argument is not of the declared type or below it."),
    "E0203": CodeInfo("unit mismatch", "type",
        "Lengths, angles, times and plain numbers do not mix."),
    "E0204": CodeInfo("unknown parameter", "type",
        "The declaration has no parameter of this name."),
    "E0205": CodeInfo("bad parameter value", "type",
        "The value does not fit the type of the parameter."),
    "E0206": CodeInfo("missing argument", "type",
        "A parameter without default needs an argument."),
    "E0207": CodeInfo("function out of place", "type",
        "Some functions work only while the scene is built, only in rules, or only in motion predicates."),
    "E0208": CodeInfo("wrong kind of value", "type",
        "A number, a vector, an object or a chain is needed here."),
    "E0209": CodeInfo("wrong brackets", "type",
        "Logic literals stand in parentheses, motion literals in square brackets."),
    "E0210": CodeInfo("bad option value", "type",
        "The option does not take this value."),
    "E0211": CodeInfo("division by zero", "type", "The divisor is zero for the parameters given."),
    "E0212": CodeInfo("unknown objective", "type",
        "What can be minimised is actions (their cost), duration (seconds of motion, of all robots together), makespan "
        "(seconds until the last action is done), travel (how far joints move) and energy (joules, with `physics` "
        "on)."),
    "E0214": CodeInfo("weight that is not positive", "type",
        "What is minimised is a cost: a negative weight would make plans better the longer they are, and with all "
        "weights zero all plans are alike."),
    "E0215": CodeInfo("objectives without a unit in common", "type",
        "An objective is a sum of measures of a plan, each times a plain number: what a second, a radian, a joule or "
        "an action counts. Lengths and times are no weights, and numbers alone measure nothing."),
    "E0301": CodeInfo("unbound variable", "logic",
        "Every variable is a parameter or bound by exists, forall or for."),
    "E0302": CodeInfo("contradicting effects", "logic",
        "One rule adds and deletes the same literal."),
    "E0303": CodeInfo("wildcard out of place", "logic",
        "ANY stands only in the literals of conditions, in deleted ones and after `previous is`."),
    "E0304": CodeInfo("wrong `functional in`", "logic",
        "It names one parameter of the same predicate."),
    "E0305": CodeInfo("effect on a fixed predicate", "logic",
        "Static and derived predicates cannot be changed by a rule."),
    "E0306": CodeInfo("two values for a functional predicate", "logic",
        "`functional in A` allows one literal for each A: among the facts, in the goal, and after every action. A rule "
        "that gives a new value deletes the old one."),
    "E0307": CodeInfo("circular derived predicate", "logic",
        "A derived predicate cannot use itself, directly or through others."),
    "E0308": CodeInfo("wrong `symmetric`", "logic",
        "A symmetric predicate has two parameters of one type."),
    "E0309": CodeInfo("name bound twice", "logic",
        "A variable is bound once in its declaration."),
    "E0310": CodeInfo("motion literal in a condition", "logic",
        "Motion literals are effects; conditions read logic literals."),
    "E0311": CodeInfo("construct out of place", "logic", "`previous is` and `prune` stand only in heuristics."),
    "E0312": CodeInfo("function uses itself", "logic",
        "A declared function stands for its value, so it cannot use itself, directly or through others."),
    "E0313": CodeInfo("index without bound", "logic",
        "The modules of a chain are counted from 1 to its length; a rule that counts them asks for the length."),
    "E0314": CodeInfo("stands for too much", "logic",
        "Functions and derived predicates are put in wherever they are used. Where each uses the one before twice, the "
        "program doubles with every line; all uses together may add 20,000 terms, or twice the text itself."),
    "E0401": CodeInfo("sides of different size", "motion",
        "Both sides of a row have the same number of components, or one is a plain 0."),
    "E0402": CodeInfo("wrong operator", "motion",
        "Rows of motion predicates compare by =, <= or >=."),
    "E0404": CodeInfo("wrong `keep`", "motion",
        "`keep` holds one value constant; `pose` stands only there."),
    "E0405": CodeInfo("constant motion row", "motion",
        "The row does not depend on any parameter of the predicate."),
    "E0406": CodeInfo("wrong `touching`", "motion",
        "`touching X Y` names two objects of the predicate that may touch as long as the literal holds."),
    "E0501": CodeInfo("bad placement", "scene",
        "Something is put `on` a thing that cannot carry it, or beside its top."),
    "E0502": CodeInfo("overlap at the start", "scene",
        "Two bodies occupy the same space before anything moves, and one of them can move."),
    "E0503": CodeInfo("unreachable goal", "scene",
        "No rule adds a literal of the goal, even if nothing is ever deleted."),
    "E0504": CodeInfo("no task", "scene", "`solve` needs a file that declares a task."),
    "E0505": CodeInfo("ambiguous task", "scene", "The file declares several tasks; name the one to solve."),
    "E0506": CodeInfo("no goal", "scene",
        "A task needs at least one `goal`."),
    "E0507": CodeInfo("duplicate object", "scene",
        "Two things of a scene have one name."),
    "E0508": CodeInfo("bad module", "scene",
        "A module needs effectors at both ends and joints with lower < upper limits and a home value between "
        "them."),
    "E0509": CodeInfo("bad shape", "scene",
        "Shapes are box(x, y, z), sphere(r), capsule(r, length), cylinder(r, length) with positive sizes, "
        "hull((x, y, z), …) of at least four corners that do not lie in a plane, mesh(FILE) or hull(FILE), and of "
        "bodies and effectors union(box(x, y, z) at (x, y, z), …)."),
    "E0510": CodeInfo("too many objects", "scene",
        "The loops of the scene make more things than can be planned for."),
    "E0511": CodeInfo("more than one", "scene",
        "A task has one goal, the parts of which are joined by `and`, and at most one guide."),
    "E0512": CodeInfo("scene uses itself", "scene", "A scene cannot contain itself, directly or through others."),
    "E0513": CodeInfo("unreadable URDF", "scene",
        "The file of a module from a URDF is missing, or is not XML with one `robot`."),
    "E0514": CodeInfo("unfit URDF", "scene",
        "The links of a URDF form one tree. Revolute and prismatic joints have limits, in the file or in the module."),
    "E0515": CodeInfo("mesh not found", "scene",
        "The file of a mesh, of a body or in a URDF, is missing or cannot be read."),
    "E0516": CodeInfo("bad course", "scene",
        "`moves` and `disturb` name a body, a speed above 0 and a time that is not negative; a body starts one course "
        "at a time."),
    "E0517": CodeInfo("bad breakdown", "scene",
        "`fail` names a module, a time that is not negative, and `locked` or `gone`."),
    "E0518": CodeInfo("mesh that cannot be split", "scene",
        "A mesh that is not convex is cut into convex parts along its faces, or split by `coacd` where it has too "
        "many; one with holes holds nothing that can be told. `hull` takes the hull of a mesh, `union` joins parts."),
    "E0519": CodeInfo("unfit parameter", "scene",
        "A value on the command line names a parameter of the task and fits its type and range: a finite number, with "
        "a unit where the type has units."),
    "E0520": CodeInfo("row that is false at the start", "scene",
        "The `during` rows of motion literals that hold at the start, by a fact or a placement, must be true there. "
        "Rows `at switch` ask nothing of the start: they bind where an action adds a literal."),
    "E0521": CodeInfo("bad coupling", "scene",
        "A coupled joint is a multiple of one other joint of its module and of its kind, plus a value. No joint "
        "follows itself, directly or through others, and the limits of both leave them something to move in."),
    "E0522": CodeInfo("statement of weight or strength that makes no sense", "scene",
        "A part states what it does not have, says something twice, or gives a number that cannot be: masses, "
        "densities and strengths are positive, a coefficient of friction is at most 100. What is not known is left "
        "out: then there is no limit, and a mass is that of water. Ends and bodies hold as bond, dock, grip, pad or "
        "rest, by force, shear, moment, twist and friction."),
    "E0523": CodeInfo("does not bear itself at the start", "scene",
        "With `physics` on, the scene cannot even stand as it is: the load of a joint, dock or foot, times `safety`, "
        "is more than it states to bear. No plan can begin there."),
    "E0524": CodeInfo("energy without physics", "scene",
        "Energy is the work of joints against their torques, which only `physics` tells."),
    "S0001": CodeInfo("infeasible", "outcome", "It is proved that no sequence of actions reaches the goal."),
    "S0002": CodeInfo("exhausted", "outcome",
        "Every candidate sequence was refused by the motion solver; this is no proof."),
    "S0003": CodeInfo("budget spent", "outcome", "Time or nodes were spent before a plan was found."),
    "S0004": CodeInfo("plan refused", "outcome",
        "The verifier measured a violation in the plan, or the plan is not one of the task that it is held against."),
    "S0005": CodeInfo("interrupted", "outcome", "The user ended the run."),
    "S0006": CodeInfo("no cluster", "outcome",
        "No cluster answers at the address, or its workers are not fit for the work: each runs one thread, and has the "
        "same version of tamplang."),
    "S0007": CodeInfo("work lost", "outcome",
        "The process that had the work ended before it was done, and so did the one that took over; the system may "
        "have run out of memory."),
    "S0008": CodeInfo("robot lost", "outcome",
        "In mid-run a module left the scene that carried the rest of its robot, or that held something."),
    "S0009": CodeInfo("robot struck", "outcome",
        "In mid-run something that moves by itself goes right through a robot, which does not get out of its way."),
    "S0010": CodeInfo("memory spent", "outcome",
        "The memory that --memory gives, or 80 % of what was free at the start, was not enough."),
    "S0011": CodeInfo("plan not verified", "outcome",
        "Time or memory were spent before the verifier had a verdict on what was planned or carried out."),
    "S0012": CodeInfo("no physics engine", "outcome",
        "`simulate` and `run --engine mujoco` need MuJoCo, which the extra `sim` brings: pip install 'tamplang[sim]'."),
    "S0013": CodeInfo("simulation that broke down", "outcome",
        "The physics engine met numbers that make no sense, or a module flew off: what it says of that time and later "
        "means nothing. It is no word on the plan."),
    "S0014": CodeInfo("no display", "outcome",
        "`simulate --view` opens a window, which needs a display."),
    "S0015": CodeInfo("missing extra", "outcome",
        "What was asked for needs a library that tamplang does without elsewhere. The hint names the extra that brings "
        "it: `notebook` for tables and figures, `ros` for bags, `pictures` for images and videos."),
    "S0016": CodeInfo("gave way", "outcome",
        "In a run with a physics engine a dock, a grip or a foot broke, or something is no longer where the run has "
        "it, as where a drive is too weak."),
    "W0001": CodeInfo("deletes what nothing adds", "warning",
        "No rule, fact or placement ever adds a literal that fits."),
    "W0002": CodeInfo("never read", "warning", "No condition, goal or derived predicate reads this predicate."),
    "W0003": CodeInfo("rule can never fire", "warning", "Its conditions cannot hold, even if nothing is ever deleted."),
    "W0004": CodeInfo("negative cycle", "warning", "Actions that cancel each other make the heuristic ever smaller."),
    "W0005": CodeInfo("unused parameter", "warning", "The declaration never uses this parameter."),
    "W0006": CodeInfo("simplified mesh", "warning",
        "Convex parts have at most 100 corners. A finer one is replaced by one of 26 faces around it, a mesh of a URDF "
        "by its hull, and one that `coacd` splits by parts that are somewhat larger."),
    "W0007": CodeInfo("moves into something", "warning",
        "A body that moves on its own gets into a thing that stands still at the start. Nothing stops it."),
    "W0008": CodeInfo("scene that moves", "warning",
        "`solve` plans for the scene as it is at time 0; what moves or fails later is not seen."),
    "W0009": CodeInfo("out of reach", "warning",
        "Even if all modules of the scene joined to one chain, as long as can be, no rule could bring about what the "
        "goal asks for; or it asks for more at once than the modules can do. `solve` proves it."),
    "W0010": CodeInfo("passed over in a URDF", "warning",
        "A collision shape without volume, or of an unknown kind, is left out, as is one for which the shape of an "
        "effector stands, since it lies in it. `quat_xyzw` and `capsule` count from "
        "version 1.1 of URDF on, as other readers have it. A joint without a way between its limits is fixed. An "
        "inertial that no body can have states nothing."),
    "W0011": CodeInfo("damaged results", "warning",
        "Some lines in the results file of a sweep hold no result. They stay where they are; the instances that have "
        "no other line are solved again."),
    "W0012": CodeInfo("built into each other", "warning",
        "Two bodies that never move occupy the same space, as a wall that is let into the floor. Nothing comes of it, "
        "unless one of them lies elsewhere than was meant."),
    "W0013": CodeInfo("joint that nothing can move", "warning",
        "A joint without a drive moves only while something that drives move holds its module. No rule ever has "
        "anything do so, by the types of its variables."),
    "W0014": CodeInfo("length without unit", "warning",
        "A plain number where a length is meant counts in metres. Better say so."),
    "W0015": CodeInfo("rule without effect", "warning",
        "A rule without `post` changes nothing, so that no plan needs it."),
    "W0016": CodeInfo("declares nothing", "warning",
        "The file holds only blanks and comments, so that nothing can be solved and nobody can import anything."),
    "W0017": CodeInfo("end faces into its module", "warning",
        "An effector faces along z unless its `normal` says otherwise, and the links behind it go along z, too: the "
        "first end of a module usually needs `normal (0, 0, -1)`."),
    "W0018": CodeInfo("no mass stated", "warning",
        "`physics` is on, and a part states neither mass nor density: it counts as solid, of the density of water, "
        "1000 kg/m^3."),
    "W0019": CodeInfo("left out of a file of others", "warning",
        "What is imported holds this too, for which there is no counterpart, or takes it over as something else. The "
        "program is written without it."),
    "W0020": CodeInfo("end inside a link", "warning",
        "All of the shape of an effector, or its face along its normal, lies inside a link that moves with it, as a "
        "ball thinner than the rounded end of a capsule does. The link would have to go into whatever the effector is "
        "to touch, so that no plan has it touch anything there."),
    "W0021": CodeInfo("taken to have no drives", "warning",
        "No joint of the module states a drive, such as its `speed`, and none is `passive`. Since some rule wants its "
        "parts to be somewhere to each other, and none has it do anything to another thing, it is taken for something "
        "like a drawer: its joints move only while something that drives move holds it. `passive` behind the joints "
        "says so, a `speed` says otherwise."),
    "W0022": CodeInfo("unsound mesh", "warning",
        "The surface of a mesh has holes, looks inward, or has faces that are flat or there twice. What it holds is "
        "told all the same, as the message says."),
    "W0023": CodeInfo("lies on what can be moved", "warning",
        "A thing that is put `at` a point lies on top of another one that some action can move. It is carried along, "
        "as if it had been put `on` that one; of what is true at the start nothing else is added. What lies with its "
        "middle on something that never moves stays where it is."),
    "W0024": CodeInfo("no strength stated", "warning",
        "`physics` is on, and no joint states a torque or a bearing moment, and no end how it holds: what is not "
        "stated has no limit, so that nothing is refused for its weight."),
    "W0025": CodeInfo("moves what it still holds", "warning",
        "A rule deletes a literal that keeps an object where it is, and asks for it elsewhere at the same switch: "
        "what holds when an action begins holds until its switch, so that this action can move the object nowhere. Let "
        "a rule of its own let go, and the next one move."),
}


def explain(code: str) -> str:
    """The text of `tamplang explain CODE`: title, category, explanation, a wrong and a right program. Codes are matched
    without regard to case. Raises KeyError, with the near codes as its text, when there is no such code."""
    key = code.strip().upper()
    if key not in CODES:
        raise KeyError(did_you_mean(key, CODES) or "codes look like E0101, W0001 or S0001")
    return CODES[key].text(key)
