"""The one list of words is that of the grammar."""

import re

from tamplang.langs.build_terms import _UNITS as UNITS_READ
from tamplang.langs.grammar_loader import grammar_text, parser
from tamplang.langs.words import RESERVED, UNITS, WORDS


def test_the_list_has_the_words_of_the_grammar() -> None:
    patterns = (t.pattern.value.split("(?!")[0] for t in parser().terminals if t.priority)
    assert {w for p in patterns for w in re.findall(r"\w+", p)} == set(WORDS)


def test_reserved_words_are_those_that_no_name_is() -> None:
    name = re.search(r"^NAME: /\(\?!\(([\w|]+)\)", grammar_text(), re.MULTILINE)
    assert name is not None and tuple(name[1].split("|")) == RESERVED


def test_units_are_those_of_numbers() -> None:
    own = {unit: kind for unit, (_, kind) in UNITS_READ.items() if unit}
    assert own == UNITS


def test_every_word_is_explained() -> None:
    assert all(w.doc and not w.doc.endswith(".") for w in WORDS.values())
    assert {w.group for w in WORDS.values()} == {"declaration", "part", "clause", "modifier", "control"}
