#!/usr/bin/env python3
"""Draws every row that the stability laboratory measured.

    chart_stability.py DATA FOLDER

DATA is what `make stability` wrote; FOLDER gets stability-01.svg, stability-01.png and so on. `make chart-stability` runs
this.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

from feeler import charts


def main() -> None:
    data, folder = map(Path, sys.argv[1:])
    content = json.loads(data.read_text(encoding="utf-8"))
    for row in sorted({result["row"] for result in content["rows"]}):
        charts.stability(content, row, save=folder / f"stability-{row:02d}")


if __name__ == "__main__":
    main()
