"""The program texts that the tests read."""

from pathlib import Path

from tamplang.langs.reader import read_source
from tamplang.langs.source import Source

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
GOOD = sorted((HERE / "good").glob("*.tamp"))
BAD = sorted((HERE / "bad").glob("*.tamp"))
REAL = sorted([*(ROOT / "stdlib").glob("*.tamp"), *(ROOT / "examples").glob("*.tamp")])


def source_of(path: Path) -> Source:
    """The text of a file, under its bare name."""
    return Source(path.name, read_source(path).text)
