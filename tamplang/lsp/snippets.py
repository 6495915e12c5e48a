"""Beginnings of declarations and items, with the slots to fill."""

from __future__ import annotations

DECLARATIONS = {
    "type": "type ${1:name} < ${2:object}",
    "predicate": "predicate (${1:name} ${2:X}: ${3:object})",
    "derived": "derived (${1:name} ${2:X}: ${3:object}) =\n    $0",
    "function": "function ${1:name}(${2:X}: ${3:object}) =\n    $0",
    "module": "module ${1:name}(${2:size}: length = ${3:1 m}) {\n    effector A: sphere(5 cm) normal (0, 0, -1)\n"
    "    $0\n    effector B: sphere(5 cm)\n}",
    "motion": "motion [${1:name} ${2:X Y}: ${3:object}] {\n    at switch $0\n}",
    "rule": "rule ${1:name}(${2:A}: ${3:effector}) {\n    pre   $4\n    post  $0\n}",
    "placement": "placement (${1:A}: ${2:effector}) on (${3:Y}: ${4:object}) { $0 }",
    "heuristic": "heuristic ${1:name}(${2:target}: object) {\n    start  $0\n}",
    "scene": "scene ${1:name}(${2:n}: int) {\n    $0\n}",
    "task": "task ${1:name}() {\n    $0\n    goal  (${2:held target})\n}",
    "import": "import ${1:std.rules}",
}
ITEMS = {
    "for": "for ${1:i} in ${2:1} .. ${3:n} {\n    $0\n}",
    "if": "if ${1:condition} {\n    $0\n}",
    "fact": "fact ($0)",
    "goal": "goal  ($0)",
    "options": "options { ${1:time} = ${2:60 s} }",
    "effector": "effector ${1:A}: ${2:sphere(5 cm)}",
    "joint": "joint ${1:j}: ${2:revolute}(${3:y}) in ${4:-90 deg} .. ${5:90 deg}",
    "link": "link ${1:10 cm}: ${2:capsule(4 cm)}",
    "branch": "branch {\n    $0\n}",
    "during": "during $0",
    "keep": "keep pose(${1:Y}, ${2:X})",
    "exists": "exists ${1:X}: ${2:object} { $0 }",
    "forall": "forall ${1:X}: ${2:object} { $0 }",
}
