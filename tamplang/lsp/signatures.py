"""The parameters of what is being written: `scene stairs(`, `distance(`, `(on `, `[stable `."""

from __future__ import annotations

from lsprotocol import types

from ..compiler.builtins import FUNCTIONS
from ..compiler.naming import Naming
from ..langs.words import JOINTS, SHAPES
from .documents import Documents
from .where import context_at

HOMES = {
    "function": ("function",),
    "predicate": ("predicate", "derived predicate"),
    "motion": ("motion predicate",),
    "rule": ("rule",),
    "scene": ("scene",),
    "heuristic": ("heuristic",),
    "module": ("module",),
}
_SHAPES = {
    "box": ("x", "y", "z"), "sphere": ("radius",), "capsule": ("radius", "length"), "cylinder": ("radius", "length"),
    "mesh": ("file", "unit"), "hull": ("corner",), "revolute": ("axis",), "prismatic": ("axis",),
    "planar": ("x", "y"),
}  # fmt: skip


def parameters_of(naming: Naming, kind: str, name: str) -> list[tuple[str, str]]:
    """Names and types of the parameters of a declaration of that kind."""
    for home in HOMES[kind]:
        found = naming.of_home("variable", f"{home} {name}")
        if found:
            return [(p.definition.mention.name, p.definition.type) for p in found]
    return []


def signature_help(documents: Documents, uri: str, position: types.Position) -> types.SignatureHelp | None:
    source = documents.source(uri)
    use = context_at(source, documents.places(source).offset(position)).use
    if use is None:
        return None
    naming = documents.naming(uri)
    shown = parameters_of(naming, use.kind, use.name)
    labels = [f"{n}: {t}" if t else n for n, t in shown]
    doc = next((p.definition.doc for p in naming.definitions([use.kind]) if p.definition.mention.name == use.name), "")
    if not labels and use.kind == "function":
        labels = list(_SHAPES.get(use.name, FUNCTIONS[use.name].overloads[0] if use.name in FUNCTIONS else ()))
        doc = FUNCTIONS[use.name].doc if use.name in FUNCTIONS else SHAPES.get(use.name) or JOINTS.get(use.name) or ""
    if not labels:
        return None
    opening, between, closing = {"predicate": ("(", " ", ")"), "motion": ("[", " ", "]")}.get(
        use.kind, ("(", ", ", ")")
    )
    literal = use.kind in ("predicate", "motion")
    text = f"{opening}{use.name} " if literal else f"{use.name}{opening}"
    parameters = []
    for index, label in enumerate(labels):
        text += between if index else ""
        parameters.append(types.ParameterInformation((len(text), len(text) + len(label))))
        text += label
    found = types.SignatureInformation(text + closing, doc or None, parameters)
    return types.SignatureHelp([found], 0, min(use.argument, len(labels) - 1))
