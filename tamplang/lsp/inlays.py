"""What the text leaves out: names of parameters at arguments that go by place, and values in SI units."""

from __future__ import annotations

from lsprotocol import types

from ..compiler.naming import Naming
from ..langs import syntax
from ..langs.parser import parse
from ..langs.source import Source
from ..langs.trees import parts
from .documents import Documents
from .signatures import parameters_of

_SI = {"length": "m", "angle": "rad", "time": "s"}


def inlay_hints(documents: Documents, uri: str, within: types.Range) -> list[types.InlayHint]:
    source = documents.source(uri)
    places = documents.places(source)
    first, last = places.offset(within.start), places.offset(within.end)
    naming = documents.naming(uri)
    found = []
    for node in parts(parse(source)[0].declarations):
        if not isinstance(node, syntax.Node) or node.span.end < first or node.span.start > last:
            continue
        for offset, label, kind in _hints(naming, source, node):
            if first <= offset <= last:
                is_name = kind == types.InlayHintKind.Parameter
                found.append(
                    types.InlayHint(
                        places.position(offset), label, kind, padding_left=not is_name, padding_right=is_name
                    )
                )
    return found


def _hints(naming: Naming, source: Source, node: syntax.Node) -> list[tuple[int, str, types.InlayHintKind]]:
    match node:
        case syntax.SceneUse(name=name, args=args):
            return _named(naming, "scene", name, args)
        case syntax.GuideUse(name=name, args=args):
            return _named(naming, "heuristic", name, args)
        case syntax.RobotItem(type=name, args=args):
            return _named(naming, "module", name, args)
        case syntax.Call(function=name, args=terms):
            names = parameters_of(naming, "function", name)
            return [
                (t.span.start, f"{n}:", types.InlayHintKind.Parameter)
                for t, (n, _) in zip(terms, names, strict=False)
                if not isinstance(t, syntax.Name)
            ]
        case syntax.Number(kind=kind, text=text, value=value) if kind in _SI:
            if text.split()[-1:] != [_SI[kind]] and kind != "length":
                return [(node.span.end, f"{value:.4g} {_SI[kind]}", types.InlayHintKind.Type)]
    return []


def _named(
    naming: Naming, kind: str, name: str, args: tuple[syntax.Argument, ...]
) -> list[tuple[int, str, types.InlayHintKind]]:
    names = parameters_of(naming, kind, name)
    found = []
    for argument, (parameter, _) in zip(args, names, strict=False):
        same = isinstance(argument.value, syntax.Name) and argument.value.name == parameter
        if argument.name is None and not same:
            found.append((argument.span.start, f"{parameter}:", types.InlayHintKind.Parameter))
    return found
