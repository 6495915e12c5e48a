"""Trust in figures: tampered plans, mutated programs, growth, signals, budgets, two solvers, the same plan again.

    tamplang bench trust [--part NAME]… [--count N] [--seed N] [--resume] [--folder DIR] [--markdown FILE.md]

Results are kept in DIR (./trust-results) as they come; with --resume what stands there is not measured again. --count
is the number of cases of each part instead of its own. Ends with status 1 when a promise is not kept.
"""

from __future__ import annotations

import argparse
import importlib
import os
import sys
from pathlib import Path

for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(name, "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

from benchmarks.trust.journal import Line, Settings, table  # noqa: E402

PARTS = ("plans", "tamper", "programs", "growth", "signals", "budgets", "solvers", "determinism")


def main() -> int:
    parser = argparse.ArgumentParser(prog="tamplang bench trust", description=(__doc__ or "").partition("\n")[0])
    there = [p for p in PARTS if (Path(__file__).parent / f"{p}.py").exists()]
    parser.add_argument("--part", action="append", choices=there, help="only this part; may be repeated")
    parser.add_argument("--count", type=int, help="how many cases of each part")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--resume", action="store_true", help="go on with the results in the folder")
    parser.add_argument("--folder", type=Path, default=Path("trust-results"), help="where results are kept")
    parser.add_argument("--markdown", type=Path, help="write the table there, too")
    given = parser.parse_args()
    settings = Settings(given.folder.resolve(), given.seed, given.count, given.resume)
    lines: list[Line] = []
    for part in given.part or there:
        lines += importlib.import_module(f"benchmarks.trust.{part}").run(settings)
    text = table(lines)
    print(text, end="")
    if given.markdown is not None:
        given.markdown.write_text(text, encoding="utf-8")
    return 0 if all(line.kept for line in lines) else 1


if __name__ == "__main__":
    sys.exit(main())
