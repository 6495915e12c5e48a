"""Speed and size against another build: CPU seconds, peak memory and plan files, both builds alternating in one run.

    tamplang bench speed --baseline PYTHON [--row TEXT]… [--long] [--runs 5] [--seed 0] [--out FILE.json]
        [--markdown FILE.md]

PYTHON is the interpreter of the other build. Every figure is of a whole process, byte code cached, on one core; both
builds read the same texts. Rows that take minutes run with --long only. With --out, runs are kept in FILE.json as they
end, and not run again.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from benchmarks.speed.rows import ROWS, Row
from benchmarks.speed.runs import Runs, measured
from benchmarks.speed.table import markdown


def chosen(texts: Sequence[str], long: bool) -> list[Row]:
    """The rows whose names contain one of the texts, all without texts; the long ones only where asked for."""
    return [r for r in ROWS if (long or not r.long) and (not texts or any(t in r.name for t in texts))]


def main() -> int:
    parser = argparse.ArgumentParser(prog="tamplang bench speed", description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--baseline", type=Path, required=True, metavar="PYTHON", help="interpreter of the other build")
    parser.add_argument("--row", action="append", default=[], help="only rows whose name contains this; repeatable")
    parser.add_argument("--long", action="store_true", help="the rows that take minutes, too")
    parser.add_argument("--runs", type=int, default=5, help="runs of each row and build")
    parser.add_argument("--seed", type=int, default=0, help="seed of the first run; the others have the next ones")
    parser.add_argument("--out", type=Path, help="JSON file that keeps the runs")
    parser.add_argument("--markdown", type=Path, help="write the table there, too")
    given = parser.parse_args()
    rows = chosen(given.row, given.long)
    if not rows:
        names = "\n".join(f"{row.name}{' (--long)' if row.long else ''}" for row in ROWS)
        sys.exit(f"no row is chosen; the rows are:\n{names}")
    builds = {"other": given.baseline, "this": Path(sys.executable)}
    runs: Runs = {}
    with tempfile.TemporaryDirectory() as folder:
        runs = measured(rows, builds, range(given.seed, given.seed + given.runs), Path(folder), given.out)
    text = markdown([row for row in ROWS if row.name in runs], runs)
    print(text, end="")
    if given.markdown is not None:
        given.markdown.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
