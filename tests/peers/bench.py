"""Measures feeler beside Embree, POV-Ray and itself, and prints what came out as a table.

bench.py [--quick] [--row NAME] … [--repeat N] [--json FILE] [--embree PROGRAM]
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import sys
import time
from pathlib import Path

from bench_growth import growth
from bench_programs import EMBREE, FEELER, FOLDER, MissingError
from bench_rows import ROWS, Plan, Result

ALL_ROWS = {**ROWS, "growth": growth}
COLUMNS = "{:<12} {:<26} {:>10} {:>10} {:>10} {:>15}  {:<10} {}"


def parse() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--quick", action="store_true", help="smaller pictures, 3 pairs, no growth: minutes")
    parser.add_argument("--row", action="append", choices=ALL_ROWS, help="only this row (again for more)")
    parser.add_argument("--repeat", type=int, help="pairs of a row (default 7)")
    parser.add_argument("--json", type=Path, default=FOLDER / "bench.json", help="where the results go, too")
    parser.add_argument("--embree", type=Path, default=EMBREE, help="another tracer of the same command line")
    return parser.parse_args()


def describe_machine() -> str:
    names = [line.partition(":")[2].strip() for line in Path("/proc/cpuinfo").read_text().splitlines()
             if line.startswith("model name")]  # fmt: skip
    return f"{names[0] if names else platform.machine()}, {os.cpu_count()} cores"


def _limit(result: Result) -> str:
    if result.wanted is None:
        return ""
    return f"{'≥' if result.at_least else '≤'} {result.wanted:g} {result.unit}"


def _seconds(value: float | None) -> str:
    return "" if value is None else f"{value:.3f} s"


def format_line(result: Result) -> str:
    verdict = {True: "pass", False: "short", None: ""}[result.passes]
    if result.passes and result.aim is not None:
        reached = result.value.median >= result.aim if result.at_least else result.value.median <= result.aim
        verdict += ", aim reached" if reached else f", aim {result.aim:g}"
    value = f"{result.value.median:.2f} {result.unit}"
    quartiles = f"{result.value.low:.2f} … {result.value.high:.2f}"
    line = COLUMNS.format(
        result.row,
        result.case,
        _seconds(result.ours),
        _seconds(result.theirs),
        value,
        quartiles,
        _limit(result),
        verdict,
    ).rstrip()
    return f"{line}\n{'':13}{result.note}" if result.note else line


def say(text: str) -> None:
    print(f"  … {text}", file=sys.stderr)


def measure(plan: Plan, names: list[str]) -> tuple[list[Result], list[str]]:
    """The results, each printed as it comes, and what could not be measured."""
    results, missing = [], []
    for name in names:
        try:
            for result in ALL_ROWS[name](plan):
                print(format_line(result), flush=True)
                results.append(result)
        except MissingError as error:
            print(f"{name:<12} not measured: {error}")
            missing.append(f"{name}: {error}")
    return results, missing


def main() -> int:
    chosen = parse()
    if not FEELER.is_file():
        sys.exit(f"{FEELER.name} is not built: run `make`")
    FOLDER.mkdir(parents=True, exist_ok=True)
    names = chosen.row or [name for name in ALL_ROWS if not (chosen.quick and name == "growth")]
    repeat = chosen.repeat or (3 if chosen.quick else 7)
    plan = Plan(max(1, repeat), chosen.quick, chosen.embree.resolve(), say)
    about = {
        "date": time.strftime("%Y-%m-%d %H:%M"),
        "machine": describe_machine(),
        "load": os.getloadavg()[0],
        "pairs": plan.repeat,
        "quick": plan.quick,
    }
    quick = ", smaller pictures than the full table's" if plan.quick else ""
    print(f"{about['date']}, {about['machine']}, load {about['load']:.1f}, {plan.repeat} pairs{quick}")
    print(COLUMNS.format("row", "scene", "ours", "theirs", "median", "quartiles", "wanted", "").rstrip())
    results, missing = measure(plan, names)
    everything = {**about, "results": [result.as_json() for result in results], "missing": missing}
    chosen.json.write_text(json.dumps(everything, indent=1) + "\n")
    short = sum(result.passes is False for result in results)
    print(f"{short} short, {len(missing)} not measured; also in {os.path.relpath(chosen.json)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
