"""What every chart shares: matplotlib, which only charts need, and how a figure is written."""

from __future__ import annotations

import os
from pathlib import Path

from ._replacement import replacement

try:
    import matplotlib
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch, Rectangle
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
except ImportError as error:
    raise ImportError("feeler.charts needs matplotlib: pip install 'feeler[charts]'") from error

__all__ = [
    "Figure",
    "FuncFormatter",
    "Line2D",
    "LogLocator",
    "NullFormatter",
    "Patch",
    "Rectangle",
    "number",
    "save_figure",
]


def save_figure(figure: Figure, path: str | os.PathLike[str]) -> None:
    """Writes a figure as PNG and as SVG; the endings are added, or replace each other."""
    base = Path(path)
    if base.suffix in (".png", ".svg"):
        base = base.with_suffix("")
    # The same results make the same file: no date, and names that do not hang on chance.
    with matplotlib.rc_context({"svg.hashsalt": "feeler", "svg.fonttype": "none"}):
        with replacement(base.with_name(f"{base.name}.png")) as file:
            figure.savefig(file, format="png", dpi=110)
        with replacement(base.with_name(f"{base.name}.svg")) as file:
            figure.savefig(file, format="svg", metadata={"Date": None})


def number(value: float) -> str:
    """Three digits that count, without an exponent."""
    return f"{value:.0f}" if value >= 100 else f"{value:.3g}"
