"""Draws one row of the stability laboratory: failures over what provokes them, a chart for each thing measured."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ._figure import Figure
from ._library import BAD_INPUT, Error

# By kind: line, colour, and the markers of the first curve of it, the second, …
_STYLES = {
    "naive": ("-", "black", "x+1"),
    "robust": ("-", "black", "oD"),
    "double": ("--", "0.35", "sD"),
    "other": (":", "0.35", "^v<"),
}
_FILLED = {"robust"}


def draw_row(data: str | os.PathLike[str] | Mapping[str, Any], row: int, width: float) -> Figure:
    """What `make stability` measured for one row of the catalogue: its charts side by side, its cost below."""
    source = "" if isinstance(data, Mapping) else os.fspath(data)
    try:
        content = data if isinstance(data, Mapping) else json.loads(Path(source).read_text(encoding="utf-8"))
        found = [result for result in content["rows"] if result["row"] == row]
        if not found:
            raise Error(f"there is no row {row}", source=source, code=BAD_INPUT)
        return _draw(found, width)
    except OSError as error:
        raise Error(f"cannot be read: {error.strerror}", source=source, code=BAD_INPUT) from None
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise Error(f"is not what the stability laboratory writes ({error!r})", source=source, code=BAD_INPUT) from None


def _draw(results: Sequence[Mapping[str, Any]], width: float) -> Figure:
    panels = [panel for result in results for panel in result["panels"]]
    figure = Figure(figsize=(width * len(panels), 0.86 * width), layout="constrained")
    for axes, panel in zip(figure.subplots(1, len(panels), squeeze=False)[0], panels, strict=True):
        _draw_panel(axes, panel)
    gap = "\n" if len(panels) == 1 else " "
    costs = [_describe_cost(result["cost"], gap) for result in results if result.get("cost")]
    if costs:
        figure.supxlabel("\n".join(costs), fontsize=8)
    return figure


def _describe_cost(cost: Mapping[str, Any], gap: str) -> str:
    return (
        f"time of the remedy: {cost['ratio']:.2f} × the naive one's{gap}"
        f"(quartiles {cost['low']:.2f}, {cost['high']:.2f}; {cost['what']})"
    )


def _draw_panel(axes: Any, panel: Mapping[str, Any]) -> None:
    words = any(isinstance(x, str) for x in panel["x"])
    x = np.arange(len(panel["x"])) if words else np.array(panel["x"], float)
    floor = _floor(panel)
    count = dict.fromkeys(_STYLES, 0)
    for curve in panel["curves"]:
        kind = curve["kind"]
        line, colour, markers = _STYLES[kind]
        values = np.array(curve["values"], float)
        values[~np.isfinite(values)] = np.nan
        if panel["y_log"]:
            values = np.maximum(values, floor)
        axes.plot(
            x, values, line, color=colour, marker=markers[count[kind] % len(markers)], label=curve["name"],
            markersize=5 if kind in _FILLED else 8, markerfacecolor=colour if kind in _FILLED else "none",
            linewidth=1.1, clip_on=False, zorder=3 if kind in _FILLED else 2,
        )  # fmt: skip
        count[kind] += 1
        bound = np.broadcast_to(np.nan if curve["bound"] is None else np.array(curve["bound"], float), x.shape)
        if kind in _FILLED and (bound > 0).all():
            axes.plot(x, bound, "-.", color="0.6", linewidth=0.9, label="the bound that is claimed for it", zorder=1)
    if panel["x_log"] and not words:
        axes.set_xscale("log")
    if words:
        axes.set_xticks(x, panel["x"], rotation=30, ha="right", fontsize=8)
    if panel["y_log"]:
        _scale_logarithmically(axes, panel, floor)
    of = f" of {panel['tries']}" if panel["tries"] else ""
    axes.set_title(panel["title"], fontsize=10)
    axes.set_xlabel(panel["x_name"], fontsize=9)
    axes.set_ylabel(f"{panel['y_name']}{of and ', share'}", fontsize=9)
    axes.tick_params(labelsize=8)
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(color="0.9", linewidth=0.6)
    longest = max(len(str(x)) for x in panel["x"]) if words else 0
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.17 - 0.009 * longest), frameon=False, fontsize=8, ncols=2)


def _floor(panel: Mapping[str, Any]) -> float:
    """Where what is 0 is drawn: under everything else, on a power of ten."""
    positive = [v for curve in panel["curves"] for v in curve["values"] if v and v > 0 and math.isfinite(v)]
    least = min([*positive, *([1 / panel["tries"]] if panel["tries"] else [])], default=1e-3)
    return float(10.0 ** math.floor(math.log10(least / 2) + 1e-9))


def _scale_logarithmically(axes: Any, panel: Mapping[str, Any], floor: float) -> None:
    """Powers of ten, and a place for what is 0."""
    axes.set_yscale("log")
    drawn = np.concatenate([line.get_ydata() for line in axes.get_lines()])
    top = np.nanmax(drawn, initial=10 * floor)
    low, high = round(math.log10(floor)), math.ceil(math.log10(top))
    step = max(1, (high - low) // 8)
    powers = list(range(low + 1, high + 1, step))
    zero = any(v == 0 for curve in panel["curves"] for v in curve["values"])
    labels = [f"$10^{{{p}}}$" if p else "1" for p in powers]
    if zero:
        labels = [f"0 of {panel['tries']}" if panel["tries"] else "0", *labels]
    axes.set_yticks([*([floor] if zero else []), *(10.0**p for p in powers)], labels, fontsize=8)
    axes.minorticks_off()
    axes.set_ylim(floor, 10.0**high if top <= 10.0**high else None)
