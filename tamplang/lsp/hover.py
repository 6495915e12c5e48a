"""What the word under the cursor is: declarations with their texts, words of the language, functions, parts."""

from __future__ import annotations

from lsprotocol import types

from ..compiler.builtins import FUNCTIONS
from ..compiler.mentions import Mention
from ..compiler.naming import Place
from ..compiler.objectives import MEASURES
from ..compiler.options import OPTIONS
from ..langs.parser import parse_tokens
from ..langs.source import Source
from ..langs.words import ATTRIBUTES, JOINTS, SHAPES, TYPES, WORDS
from .documents import Documents


def hover(documents: Documents, uri: str, position: types.Position) -> types.Hover | None:
    """What stands at a place, as Markdown."""
    source = documents.source(uri)
    places = documents.places(source)
    offset = places.offset(position)
    mention = documents.mention(uri, position)
    if mention is None:
        return _keyword(documents, source, offset)
    place = documents.naming(uri).meant(source.path, mention)
    text = built_in(mention) if place is None else described(place)
    if text is None:
        return None
    return types.Hover(_markdown(text), places.range(mention.start, mention.end))


def described(place: Place) -> str:
    """The head of a definition, what it is, and its `##` text."""
    definition = place.definition
    what = definition.what + (f" of type `{definition.type}`" if definition.type else "")
    return f"```tamplang\n{head(place)}\n```\n{what}\n\n{definition.doc}".strip()


def head(place: Place) -> str:
    """The first line of the statement that declares it, or of a variable its name and type."""
    definition = place.definition
    if definition.mention.kind == "variable":
        return f"{definition.mention.name}: {definition.type}" if definition.type else definition.mention.name
    return place.source.text[definition.start : definition.end].split("\n")[0].strip().removesuffix("{").strip()


def built_in(mention: Mention) -> str | None:
    """What the language itself says of a name that no text declares."""
    name = mention.name
    if mention.kind == "function":
        if name in FUNCTIONS:
            return f"`{name}({', '.join(FUNCTIONS[name].overloads[0])})`: {FUNCTIONS[name].doc}"
        text = SHAPES.get(name) or JOINTS.get(name)
        return None if text is None else f"`{text.replace(':', '`:', 1)}"
    if mention.kind == "type" and name in TYPES:
        return f"`{name}`: {TYPES[name]}"
    if mention.kind == "attribute" and name in ATTRIBUTES:
        return f"`.{name}`: {ATTRIBUTES[name]}"
    if mention.kind == "option" and name in OPTIONS:
        return f"`{name}`: {OPTIONS[name].help}"
    taking = [o for o in OPTIONS.values() if mention.kind == "word" and name.replace("_", "-") in o.choices]
    if taking:
        return f"`{name}`: a value of the option `{taking[0].name}`. {taking[0].help}"
    if mention.kind == "word" and name in MEASURES:
        return f"`{name}`: a measure of plans, for the option `minimise`"
    return "`prune`: cuts the branch of the search off" if name == "prune" else None


def _keyword(documents: Documents, source: Source, offset: int) -> types.Hover | None:
    """The line on a word of the language; of a name with a meaning of its own nothing."""
    for token in parse_tokens(source)[1]:
        start, end = token.start_pos or 0, token.end_pos or 0
        if start <= offset <= end and str(token) in WORDS:
            where = documents.places(source).range(start, end)
            return types.Hover(_markdown(f"`{token}`: {WORDS[str(token)].doc}"), where)
    return None


def _markdown(text: str) -> types.MarkupContent:
    return types.MarkupContent(types.MarkupKind.Markdown, text)
