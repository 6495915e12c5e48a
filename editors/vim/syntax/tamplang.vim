" Vim syntax of tamplang. Written by editors/generate.py; do not change it by hand.
if exists("b:current_syntax")
  finish
endif
syn match tampFree /\<\h\w*\>/
syn match tampDeclaration /[.(\[]\@1<!\<\(heuristic\|placement\|predicate\|function\|derived\|import\|module\|motion\|scene\|rule\|task\|type\)\>(\@!/
syn match tampPart /[.(\[]\@1<!\<\(effector\|minimise\|touching\|disturb\|options\|branch\|during\|guide\|joint\|moves\|start\|where\|cost\|fact\|fail\|goal\|keep\|link\|post\|pre\)\>(\@!/
syn match tampClause /[.(\[]\@1<!\<\(acceleration\|bearing\|density\|heading\|normal\|switch\|torque\|along\|brake\|chain\|force\|holds\|rotor\|speed\|back\|from\|home\|jerk\|mass\|urdf\|at\|by\|in\|of\|on\)\>(\@!/
syn match tampModifier /[.(\[]\@1<!\<\(functional\|symmetric\|passive\|static\|borne\)\>(\@!/
syn match tampControl /[.(\[]\@1<!\<\(previous\|exists\|forall\|else\|then\|ANY\|and\|for\|max\|min\|not\|sum\|if\|is\|or\)\>(\@!/
syn match tampControl /\<\(previous\|exists\|forall\|else\|then\|ANY\|and\|for\|not\|if\|is\|or\)\>/
syn match tampType /[.(\[]\@1<!\<\(inertia\|length\|object\|region\|angle\|real\|time\|int\)\>/
syn match tampFunction /\<\(prismatic\|cylinder\|revolute\|capsule\|planar\|sphere\|union\|hull\|mesh\|box\)\>(\@=/
syn match tampPredicate /(\@1<=\h\w*\%(\%(\s\+[A-Za-z0-9_.\[\]]\+\)*)\)\@=/
syn match tampMotion /\[\@1<=\h\w*\%(\%(\s\+[A-Za-z0-9_.\[\]]\+\)\+\]\)\@=/
syn match tampNumber /\<\d\+\%(\.\d\+\)\?\%([eE][+-]\?\d\+\)\?\%(\s*\%(kg m^2\|kg\/m^3\|kg m²\|kg\/m³\|kN m\|N m\|deg\|min\|rad\|cm\|kN\|kg\|mm\|N\|g\|m\|s\)\%(\/s\%(^[23]\)\?\)\?\>\)\?/
syn region tampString start=/"/ end=/"/ oneline
syn match tampComment /#.*$/ contains=tampTodo
syn match tampDoc /##.*$/
syn keyword tampTodo TODO FIXME contained
hi def link tampDeclaration Structure
hi def link tampPart Statement
hi def link tampClause Statement
hi def link tampModifier StorageClass
hi def link tampControl Conditional
hi def link tampType Type
hi def link tampFunction Function
hi def link tampPredicate Function
hi def link tampMotion Macro
hi def link tampNumber Number
hi def link tampString String
hi def link tampComment Comment
hi def link tampDoc SpecialComment
hi def link tampTodo Todo
let b:current_syntax = "tamplang"
