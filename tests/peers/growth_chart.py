"""Draws the growth of trace time, ours beside Embree's, from what bench.py measured.

growth_chart.py build/bench/growth.json docs/growth.svg
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

TITLES = {"spheres": "spheres in a cube", "field": "height field, triangles"}


def draw(points: list[dict[str, Any]], out: Path) -> None:
    """One panel for each kind of scene, both axes logarithmic; lines are told apart without colour."""
    import matplotlib

    matplotlib.use("Agg")
    matplotlib.rcParams.update({"svg.hashsalt": "feeler", "font.size": 9})
    from matplotlib import pyplot

    figure, panels = pyplot.subplots(1, 2, figsize=(8, 3.4), sharey=True, layout="constrained")
    for panel, (kind, title) in zip(panels, TITLES.items(), strict=True):
        mine = [p for p in points if p["kind"] == kind]
        numbers = [p["primitives"] for p in mine]
        medians = [sorted(p["trace"])[len(p["trace"]) // 2] for p in mine]
        panel.loglog(numbers, medians, "k-o", label="feeler", markersize=5)
        known = [(p["primitives"], p["their_trace"]) for p in mine if p["their_trace"] is not None]
        if known:
            panel.loglog(*zip(*known, strict=True), "k--s", markerfacecolor="white", label="Embree", markersize=5)
        panel.set_title(title)
        panel.set_xlabel("primitives")
        panel.grid(True, which="major", linewidth=0.3)
        panel.legend(frameon=False)
    panels[0].set_ylabel("trace time, seconds (1024 × 1024)")
    figure.savefig(out, metadata={"Date": None} if out.suffix == ".svg" else None, dpi=150)
    pyplot.close(figure)


if __name__ == "__main__":
    draw(json.loads(Path(sys.argv[1]).read_text()), Path(sys.argv[2]))
