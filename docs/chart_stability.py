#!/usr/bin/env python3
"""Draws every row that the stability laboratory measured.

    chart_stability.py DATA FOLDER

DATA is what `make stability` wrote; FOLDER gets stability-01.svg, stability-01.png and so on. `make chart-stability`
runs this.
"""

from __future__ import annotations

import json
import re
import sys
from pathlib import Path

from feeler import charts


def shorten(svg: str) -> str:
    """Hundredths of a point are enough in tags, and nobody reads the indentation; what is written stays."""
    number = re.compile(r"\d+\.\d{3,}")
    svg = re.sub(r"<[^>]*>", lambda tag: number.sub(lambda digits: f"{float(digits[0]):.2f}", tag[0]), svg)
    return re.sub(r"\n +", "\n", svg)


def main() -> None:
    data, folder = map(Path, sys.argv[1:])
    content = json.loads(data.read_text(encoding="utf-8"))
    for row in sorted({result["row"] for result in content["rows"]}):
        path = folder / f"stability-{row:02d}.svg"
        charts.stability(content, row, save=path)
        path.write_text(shorten(path.read_text(encoding="utf-8")), encoding="utf-8")


if __name__ == "__main__":
    main()
