"""Every code of the project, with what it means and a short example of the mistake and its repair.

One flat table in the order of the codes: E00 text and syntax, E01 names and imports, E02 types and units, E03 logic,
E04 motion constraints, E05 scenes and tasks, W warnings, S outcomes of the solver.
"""

from __future__ import annotations

from .diagnostics import did_you_mean
from .explanation import CodeInfo

_TASK = "task t() { object b: sphere(4 cm) at (0, 0, 1 m) "

CODES: dict[str, CodeInfo] = {
    "E0001": CodeInfo("unexpected text", "syntax", "The text does not follow the grammar at this place; the message says "
                      "what may stand here.", "rule step(A B: effector, ) { … }", "rule step(A B: effector) { … }"),
    "E0002": CodeInfo("unknown character", "syntax", "This character has no meaning in the language outside comments and "
                      "quoted texts.", "pre (support A) & (free B)", "pre (support A) and (free B)"),
    "E0003": CodeInfo("missing punctuation", "syntax", "One sign is lacking, such as a colon, a comma or a parenthesis; "
                      "with it the rest can be read.", "effector A gripper sphere(5 cm)", "effector A: gripper sphere(5 cm)"),
    "E0004": CodeInfo("misspelt keyword", "syntax", "A word stands where only a keyword of the language can.",
                      "rule r() { pots (support A) }", "rule r() { post (support A) }"),
    "E0005": CodeInfo("missing closing bracket", "syntax", "A brace, bracket or parenthesis is opened and never closed.",
                      "type base < object\nrule r() { pre (support A)", "type base < object\nrule r() { pre (support A) }"),
    "E0006": CodeInfo("unfinished text", "syntax", "A quoted text ends on the line where it starts.",
                      'import "scenes/rubble.tamp', 'import "scenes/rubble.tamp"'),
    "E0007": CodeInfo("unknown unit", "syntax", "Units are m, cm, mm for lengths, rad, deg for angles, s, min for times, "
                      "and a length or angle per second, such as rad/s, for speeds.", "sphere(5 inch)", "sphere(127 mm)"),
    "E0008": CodeInfo("nested too deeply", "syntax", "Brackets or operators are nested deeper than the reader follows."),
    "E0009": CodeInfo("number out of range", "syntax", "A number must be finite in double precision.", "1e999 m", "1e9 m"),
    "E0010": CodeInfo("file not found", "file", "There is no file of this name."),
    "E0011": CodeInfo("unreadable file", "file", "The operating system refuses to give the contents of the file."),
    "E0012": CodeInfo("not a file", "file", "A source is a file of text, not a directory or a device."),
    "E0013": CodeInfo("empty file", "file", "The file holds no text."),
    "E0014": CodeInfo("not text", "file", "A source is text in UTF-8; this file holds other bytes."),
    "E0015": CodeInfo("file too large", "file", "A source holds at most 1 MB. Use loops for scenes of many bodies."),
    "E0016": CodeInfo("condition and value confused", "syntax", "Literals and comparisons are conditions; numbers, names "
                      "and functions are values.", "pre support", "pre (support A)"),
    "E0101": CodeInfo("unknown name", "name", "No variable, parameter or object of this name can be seen here.",
                      "goal (held targt)", "goal (held target)"),
    "E0102": CodeInfo("unknown type", "name", "Types are declared by `type` or `module`; object, effector, module and the "
                      "value types int, real, length, angle are built in.", "rule grasp(A: griper)", "rule grasp(A: gripper)"),
    "E0103": CodeInfo("unknown predicate", "name", "Literals in parentheses name a predicate declared by `predicate` or "
                      "`derived`, here or in an imported file.", "pre (suport A)", "pre (support A)"),
    "E0104": CodeInfo("unknown motion predicate", "name", "Literals in square brackets name a predicate declared by "
                      "`motion`.", "post [tuoch A X]", "post [touch A X]"),
    "E0105": CodeInfo("unknown rule", "name", "Heuristics speak of rules that are declared here or imported.",
                      "grap(A, X): 0", "grasp(A, X): 0"),
    "E0106": CodeInfo("unknown heuristic", "name", "`guide` names a heuristic.", "guide clmb(target)", "guide climb(target)"),
    "E0107": CodeInfo("unknown scene", "name", "`scene` in a task names a scene.", "scene stair(3)", "scene stairs(3)"),
    "E0108": CodeInfo("unknown module type", "name", "Only a type declared by `module` can be put into a scene as a robot.",
                      "crwler c: A on ground", "crawler c: A on ground"),
    "E0109": CodeInfo("unknown function", "name", "The functions of the language are listed in docs/language.md.",
                      "distnce(X, Y)", "distance(X, Y)"),
    "E0110": CodeInfo("duplicate declaration", "name", "A name is declared once in a file and all that it imports.",
                      "type a < object\ntype a < object", "type a < object"),
    "E0111": CodeInfo("import not found", "name", "`import std.NAME` reads the standard library, `import \"PATH\"` a file "
                      "beside the importing one.", "import std.rule", "import std.rules"),
    "E0112": CodeInfo("import cycle", "name", "Files import each other in a ring. Move what both need into a third file."),
    "E0113": CodeInfo("unknown task", "name", "The file declares no task of this name."),
    "E0114": CodeInfo("unknown attribute", "name", "A chain has .first and .last, its k-th module c[k] has .in and .out, "
                      "a module of a scene has its effectors.", "(free c.end)", "(free c.last)"),
    "E0115": CodeInfo("type cycle", "name", "A type cannot be below itself.", "type a < b\ntype b < a", "type a < object\ntype b < a"),
    "E0116": CodeInfo("unknown option", "name", "Options of a task are bound, search, time, nodes, solver, slices, margin.",
                      "options { tme = 60 s }", "options { time = 60 s }"),
    "E0117": CodeInfo("unknown effector", "name", "The module type has no effector of this name.",
                      "crawler c: C on ground", "crawler c: A on ground"),
    "E0118": CodeInfo("reserved name", "name", "This name belongs to the language and cannot be declared again.",
                      "type object", "type thing < object"),
    "E0201": CodeInfo("wrong number of arguments", "type", "Predicates, functions and rules take as many arguments as they "
                      "are declared with.", "(on A)", "(on X A)"),
    "E0202": CodeInfo("type mismatch", "type", "The argument is not of the declared type or below it.",
                      "rule r(X: object) { pre (support X) }", "rule r(X: effector) { pre (support X) }"),
    "E0203": CodeInfo("unit mismatch", "type", "Lengths, angles, times and plain numbers do not mix.",
                      "joint j: revolute(y) in 0 .. 2 m", "joint j: revolute(y) in 0 rad .. 2 rad"),
    "E0204": CodeInfo("unknown parameter", "type", "The declaration has no parameter of this name.",
                      "scene stairs(m = 3)", "scene stairs(n = 3)"),
    "E0205": CodeInfo("bad parameter value", "type", "The value does not fit the type of the parameter.",
                      "scene stairs(2.5)", "scene stairs(2)"),
    "E0206": CodeInfo("missing argument", "type", "A parameter without default needs an argument.",
                      "scene stairs()", "scene stairs(8)"),
    "E0207": CodeInfo("function out of place", "type", "Some functions work only while the scene is built, only in rules, or "
                      "only in motion predicates.", "where gap(X, Y) <= 1 m", "where distance(X, Y) <= 1 m"),
    "E0208": CodeInfo("wrong kind of value", "type", "A number, a vector, an object or a chain is needed here.",
                      "object b: sphere(b)", "object b: sphere(4 cm)"),
    "E0209": CodeInfo("wrong brackets", "type", "Logic literals stand in parentheses, motion literals in square brackets.",
                      "post [support A]", "post (support A)"),
    "E0210": CodeInfo("bad option value", "type", "The option does not take this value.",
                      "options { bound = paths }", "options { bound = path }"),
    "E0211": CodeInfo("division by zero", "type", "The divisor is zero for the parameters given."),
    "E0301": CodeInfo("unbound variable", "logic", "Every variable is a parameter or bound by exists, forall or for.",
                      "pre (on X A)   # X is no parameter", "pre exists X: object { (on X A) }"),
    "E0302": CodeInfo("contradicting effects", "logic", "One rule adds and deletes the same literal.",
                      "post (support A), not (support A)", "post (support A)"),
    "E0303": CodeInfo("wildcard out of place", "logic", "ANY stands only in deleted literals and after `previous is`.",
                      "post (on ANY A)", "post not (on ANY A)"),
    "E0304": CodeInfo("wrong `functional in`", "logic", "It names one parameter of the same predicate.",
                      "predicate (on X A: object) functional in B", "predicate (on X A: object) functional in A"),
    "E0305": CodeInfo("effect on a fixed predicate", "logic", "Static and derived predicates cannot be changed by a rule.",
                      "post (linked A B)", "post (connected A B)"),
    "E0306": CodeInfo("two values for a functional predicate", "logic", "`functional in A` allows one literal for each A.",
                      "fact (on ground c.A)\nfact (on stair c.A)", "fact (on ground c.A)"),
    "E0307": CodeInfo("circular derived predicate", "logic", "A derived predicate cannot use itself, directly or through "
                      "others."),
    "E0308": CodeInfo("wrong `symmetric`", "logic", "A symmetric predicate has two parameters of one type.",
                      "predicate (on X: object, A: effector) symmetric", "predicate (near X Y: object) symmetric"),
    "E0309": CodeInfo("name bound twice", "logic", "A variable is bound once in its declaration.",
                      "rule r(A: effector, A: object)", "rule r(A: effector, X: object)"),
    "E0310": CodeInfo("motion literal in a condition", "logic", "Motion literals are effects; conditions read logic "
                      "literals.", "pre [touch A X]", "pre (grasped A X)"),
    "E0311": CodeInfo("construct out of place", "logic", "`previous is` and `prune` stand only in heuristics."),
    "E0401": CodeInfo("sides of different size", "motion", "Both sides of a row have the same number of components, or one "
                      "is a plain 0.", "at switch position(X) = gap(X, Y)", "at switch position(X) = position(Y)"),
    "E0402": CodeInfo("wrong operator", "motion", "Rows of motion predicates compare by =, <= or >=.",
                      "at switch gap(X, Y) != 0", "at switch gap(X, Y) = 0"),
    "E0403": CodeInfo("wrong shape for a motion constraint", "motion", "The row measures what these shapes do not have.",
                      "inside(X, Y) with a round Y", "inside(X, Y) with a box Y"),
    "E0404": CodeInfo("wrong `keep`", "motion", "`keep` holds one value constant; `pose` stands only there.",
                      "at switch pose(Y, X) = 0", "keep pose(Y, X)"),
    "E0405": CodeInfo("constant motion row", "motion", "The row does not depend on any parameter of the predicate.",
                      "at switch 1 = 0", "at switch gap(X, Y) = 0"),
    "E0501": CodeInfo("bad placement", "scene", "Something is put `on` a thing that cannot carry it, or beside its top.",
                      "object b: box(…) on table at (9 m, 0)", "object b: box(…) on table at (0, 0)"),
    "E0502": CodeInfo("overlap at the start", "scene", "Two bodies occupy the same space before anything moves.",
                      _TASK + "object c: sphere(4 cm) at (0, 0, 1 m) }", _TASK + "object c: sphere(4 cm) at (1 m, 0, 1 m) }"),
    "E0503": CodeInfo("unreachable goal", "scene", "No rule adds a literal of the goal, even if nothing is ever deleted."),
    "E0504": CodeInfo("no task", "scene", "`solve` needs a file that declares a task."),
    "E0505": CodeInfo("ambiguous task", "scene", "The file declares several tasks; name the one to solve."),
    "E0506": CodeInfo("no goal", "scene", "A task needs at least one `goal`.", _TASK + "}", _TASK + "goal (held b) }"),
    "E0507": CodeInfo("duplicate object", "scene", "Two things of a scene have one name.",
                      "base a: …\nbase a: …", "base a[1]: …\nbase a[2]: …"),
    "E0508": CodeInfo("bad module", "scene", "A module needs effectors at both ends and joints with lower < upper limits "
                      "and a home value between them.", "joint j: revolute(y) in 2 rad .. -2 rad", "joint j: revolute(y) in -2 rad .. 2 rad"),
    "E0509": CodeInfo("bad shape", "scene", "Shapes are box(x, y, z), sphere(r), capsule(r, length), cylinder(r, length) "
                      "with positive sizes.", "box(1 m, 0, 1 m)", "box(1 m, 1 m, 1 m)"),
    "E0510": CodeInfo("too many objects", "scene", "The loops of the scene make more things than can be planned for."),
    "E0511": CodeInfo("more than one", "scene", "A task has at most one guide."),
    "S0001": CodeInfo("infeasible", "outcome", "It is proved that no sequence of actions reaches the goal."),
    "S0002": CodeInfo("exhausted", "outcome", "Every candidate sequence was refused by the motion solver; this is no proof."),
    "S0003": CodeInfo("budget spent", "outcome", "Time or nodes were spent before a plan was found."),
    "S0004": CodeInfo("plan refused", "outcome", "The verifier measured a violation in the plan."),
    "S0005": CodeInfo("interrupted", "outcome", "The user ended the run."),
    "W0001": CodeInfo("deletes what nothing adds", "warning", "No rule, fact or placement ever adds a literal that fits."),
    "W0002": CodeInfo("never read", "warning", "No condition, goal or derived predicate reads this predicate."),
    "W0003": CodeInfo("rule can never fire", "warning", "Its conditions cannot hold, even if nothing is ever deleted."),
    "W0004": CodeInfo("negative cycle", "warning", "Actions that cancel each other make the heuristic ever smaller."),
    "W0005": CodeInfo("unused parameter", "warning", "The declaration never uses this parameter."),
}


def explain(code: str) -> str:
    """The text of `tamplang explain CODE`: title, category, explanation, wrong and right example. Codes are matched
    without regard to case. Raises KeyError, with the near codes as its text, when there is no such code."""
    key = code.strip().upper()
    if key not in CODES:
        raise KeyError(did_you_mean(key, CODES) or "codes look like E0101, W0001 or S0001")
    return CODES[key].text(key)
