"""Runs studies, prints their tables and writes them as JSON.

PYTHONPATH=tests python -m stability [--row N]... [--json FILE] [--no-cost]
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

from . import studies
from .study import Panel, Result, broken_claims, run


def number(value: float | None) -> str:
    return "-" if value is None else f"{value:.3g}"


def print_panel(panel: Panel) -> None:
    of = f" of {panel.tries}" if panel.tries else ""
    print(f"\n  {panel.title}: {panel.y_name}{of}")
    heads = [curve.name for curve in panel.curves]
    widths = [max(len(head), 9) for head in heads]
    print("  " + panel.x_name.rjust(24) + "".join("  " + head.rjust(w) for head, w in zip(heads, widths, strict=True)))
    for i, x in enumerate(panel.x):
        cells = [number(curve.values[i]).rjust(w) for curve, w in zip(panel.curves, widths, strict=True)]
        print("  " + (x if isinstance(x, str) else number(x)).rjust(24) + "".join("  " + cell for cell in cells))


def print_result(result: Result) -> None:
    print(f"\nrow {result.row}, {result.name} (oracle: {result.oracle})")
    for panel in result.panels:
        print_panel(panel)
    if result.cost:
        c = result.cost
        print(
            f"\n  cost of the remedy: {c['ratio']:.2f} ({c['low']:.2f} … {c['high']:.2f}) times the naive time, "
            f"{c['robust_ns']:.1f} against {c['naive_ns']:.1f} ns ({c['what']})"
        )
    for broken in broken_claims(result):
        print(f"\n  NOT AS CLAIMED: {broken}")


def merge(path: Path, results: list[Result]) -> str:
    """What a file holds, with these rows in the place of their own: one row does not cost the others."""
    rows = [result.as_dict() for result in results]
    if path.exists():
        done = {row["row"] for row in rows}
        rows += [row for row in json.loads(path.read_text(encoding="utf-8"))["rows"] if row["row"] not in done]
    return json.dumps({"rows": sorted(rows, key=lambda row: row["row"])}, indent=1) + "\n"


def main() -> int:
    parser = argparse.ArgumentParser(prog="stability", description="Studies of where ray-tracing methods fail.")
    parser.add_argument("--row", type=int, action="append", help="only this row of the catalogue; may be repeated")
    parser.add_argument("--json", type=Path, help="where to write what was found, beside the other rows that are there")
    parser.add_argument("--no-cost", action="store_true", help="no times")
    chosen = parser.parse_args()
    results = []
    for study in studies():
        if not chosen.row or study.row in chosen.row:
            results.append(run(study, not chosen.no_cost))
            print_result(results[-1])
            sys.stdout.flush()
    if chosen.json:
        chosen.json.write_text(merge(chosen.json, results), encoding="utf-8")
    return int(any(broken_claims(result) for result in results))


if __name__ == "__main__":
    sys.exit(main())
