"""Charts of what feeler measured. Needs matplotlib: `pip install feeler[charts]`.

    from feeler import charts

    charts.work_groups("results.json", save="work-groups")     # writes work-groups.png and work-groups.svg
    charts.accuracy("accuracy-first.json", save="first")       # of `feeler chart`
    charts.specialisation("specialisation.json", save="both")  # of `feeler chart --specialised`
    charts.stability("stability.json", 1, save="row-1")        # of what `make stability` found

They can be read in black and white: numbers stand beside what is drawn, and hatches tell what colours would.
"""

from __future__ import annotations

import json
import os
import statistics
import textwrap
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ._accuracy_chart import accuracy
from ._figure import Figure, Patch, Rectangle, number, save_figure
from ._library import BAD_INPUT, Error
from ._specialisation_chart import specialisation
from ._stability import draw_row

__all__ = ["accuracy", "specialisation", "stability", "work_groups"]

Results = str | os.PathLike[str] | Mapping[str, Any]

# How long a label of a failure may be, in words that say what T4's words mean here.
_FAILURES = {
    "timeout": "too slow",
    "compile": "no kernel",
    "runtime": "crashed",
    "correctness": "wrong",
    "constraints": "invalid",
}
_HATCHES = {"default": "///", "forced": "...", "": ""}
_MEANINGS = {"default": "render's default", "forced": "render refuses it"}


@dataclass(frozen=True)
class _Size:
    """One work group's times on the device, milliseconds; none where it failed."""

    x: int
    y: int
    times: tuple[float, ...]
    failure: str
    kind: str  # "default", "forced" or ""

    @property
    def median(self) -> float:
        return statistics.median(self.times)

    @property
    def name(self) -> str:
        return f"{self.x}×{self.y}"


@dataclass
class _Case:
    """What one scene, device, level and number of samples gave."""

    title: str
    sizes: list[_Size] = field(default_factory=list)

    @property
    def standard(self) -> float:
        """The default's median, or without one the least: what others are compared with, milliseconds."""
        medians = [size.median for size in self.sizes if size.times]
        default = [size.median for size in self.sizes if size.times and size.kind == "default"]
        return (default or [min(medians, default=1.0)])[0]


def work_groups(
    results: Results | Sequence[Results], *, save: str | os.PathLike[str] | None = None, width: float = 6.0
) -> Figure:
    """Draws how long each work group took: bars with their spread, and below them a map of x times y.

    Every case of the results (a scene on a device, at a level, with a number of samples) is a column; several results
    stand side by side. Bars are medians of the kernel's time in milliseconds, the lines on them reach from the least
    to the greatest. The map's numbers are medians relative to the default's: 0.50 is twice as fast.

    Args:
        results: a file that `feeler bench --json` wrote, or its content as a dict (T4 schema), or several of them.
        save: where to write the chart, as PNG and as SVG; the endings are added, or replace each other.
        width: of a column, inches.

    Returns:
        The matplotlib figure.
    """
    several = [results] if isinstance(results, (str, os.PathLike, Mapping)) else list(results)
    cases = [case for one in several for case in _read(one)]
    if not cases:
        raise Error("there are no results to draw", code=BAD_INPUT)
    figure = Figure(figsize=(width * len(cases), 7.5), layout="constrained")
    axes = figure.subplots(2, len(cases), squeeze=False, height_ratios=(3, 2))
    for column, case in enumerate(cases):
        _draw_bars(axes[0][column], case)
        _draw_map(axes[1][column], case)
    if save is not None:
        save_figure(figure, save)
    return figure


def stability(
    data: str | os.PathLike[str] | Mapping[str, Any],
    row: int,
    *,
    save: str | os.PathLike[str] | None = None,
    width: float = 5.0,
) -> Figure:
    """Draws one row of the catalogue of numerical troubles: failures over what provokes them, method beside method.

    Crosses are the naive method, filled circles the robust one, open squares double. What is 0 stands at the bottom as
    "0 of N".

    Args:
        data: a file that `make stability` wrote, or its content as a dict.
        row: its number in the catalogue (docs/numerics.md), 1 to 26.
        save: where to write the chart, as PNG and as SVG; the endings are added, or replace each other.
        width: of each chart of the row, inches.

    Returns:
        The matplotlib figure.
    """
    figure = draw_row(data, row, width)
    if save is not None:
        save_figure(figure, save)
    return figure


# ---- reading ----


def _read(results: Results) -> list[_Case]:
    source = "" if isinstance(results, Mapping) else os.fspath(results)
    try:
        content = results if isinstance(results, Mapping) else json.loads(Path(source).read_text(encoding="utf-8"))
        cases: dict[str, _Case] = {}
        for result in content["results"]:
            configuration = result["configuration"]
            rest = {name: value for name, value in configuration.items() if not name.startswith("work_group")}
            case = cases.setdefault(json.dumps(rest, sort_keys=True), _Case(_title(configuration)))
            case.sizes.append(_read_size(result))
    except OSError as error:
        raise Error(f"cannot be read: {error.strerror}", source=source, code=BAD_INPUT) from None
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise Error(
            f"is no result of work groups in the T4 schema ({error!r})".removeprefix("" if source else "is "),
            source=source,
            code=BAD_INPUT,
        ) from None
    for case in cases.values():
        case.sizes.sort(key=lambda size: (size.x * size.y, size.x))
    return list(cases.values())


def _read_size(result: Mapping[str, Any]) -> _Size:
    marks = {one["name"]: one["value"] for one in result.get("measurements", ())}
    good = result["invalidity"] == "correct"
    return _Size(
        x=int(result["configuration"]["work_group_x"]),
        y=int(result["configuration"]["work_group_y"]),
        times=tuple(map(float, result["times"]["runtimes"])) if good else (),
        failure="" if good else _FAILURES.get(result["invalidity"], str(result["invalidity"])),
        kind=next((kind for kind in ("default", "forced") if marks.get(kind)), ""),
    )


def _title(configuration: Mapping[str, Any]) -> str:
    """Scene and settings in one line, the device below."""
    known = {"scene": "", "device": "", "level": "", "samples": 0, "width": 0, "height": 0, **configuration}
    scene = Path(str(known["scene"])).stem
    settings = [f"{known['width']}×{known['height']}", f"{known['samples']} samples", known["level"]]
    return "\n".join([", ".join(filter(None, [scene, *settings])), *textwrap.wrap(str(known["device"]), 60)])


# ---- drawing ----


def _draw_bars(axes: Any, case: _Case) -> None:
    top = max((max(size.times) for size in case.sizes if size.times), default=1.0)
    best = min((size.median for size in case.sizes if size.times and size.kind != "forced"), default=0.0)
    for place, size in enumerate(case.sizes):
        if not size.times:
            axes.text(place, 0.02 * top, size.failure, rotation=90, ha="center", va="bottom", style="italic")
            continue
        low, high = size.median - min(size.times), max(size.times) - size.median
        axes.bar(place, size.median, 0.7, color="0.85", edgecolor="black", hatch=_HATCHES[size.kind])
        axes.errorbar(place, size.median, [[low], [high]], color="black", capsize=4, linewidth=1.2)
        weight = "bold" if size.median == best else "normal"
        axes.text(place, max(size.times) + 0.015 * top, number(size.median), ha="center", va="bottom", weight=weight)
    axes.set_xticks(range(len(case.sizes)), [size.name for size in case.sizes], fontsize=8)
    axes.set_xlim(-0.6, len(case.sizes) - 0.4)
    axes.set_ylim(0, 1.18 * top)
    axes.set_xlabel("work group")
    axes.set_ylabel("kernel time, ms")
    axes.set_title(case.title, fontsize=9)
    axes.spines[["top", "right"]].set_visible(False)
    marks = [kind for kind in _MEANINGS if any(size.kind == kind and size.times for size in case.sizes)]
    keys = [Patch(facecolor="0.85", edgecolor="black", hatch=_HATCHES[kind], label=_MEANINGS[kind]) for kind in marks]
    if keys:
        axes.legend(handles=keys, loc="upper right", ncols=2, frameon=False, fontsize=8)


def _draw_map(axes: Any, case: _Case) -> None:
    columns = sorted({size.x for size in case.sizes})
    rows = sorted({size.y for size in case.sizes})
    ratios = [size.median / case.standard for size in case.sizes if size.times]
    low = min(ratios, default=1.0)
    reach = max(max(ratios, default=1.0) - low, 0.5)  # small differences stay pale
    for size in case.sizes:
        place = (columns.index(size.x), rows.index(size.y))
        if not size.times:
            _draw_cell(axes, place, "white", size.failure, "normal")
            continue
        ratio = size.median / case.standard
        text = f"{ratio:.2f}" + "\ndefault" * (size.kind == "default") + "\nrefused" * (size.kind == "forced")
        _draw_cell(axes, place, str(0.97 - 0.42 * (ratio - low) / reach), text, "bold" if ratio == low else "normal")
    axes.set_xticks(range(len(columns)), [str(x) for x in columns])
    axes.set_yticks(range(len(rows)), [str(y) for y in rows])
    axes.set_xlim(-0.5, len(columns) - 0.5)
    axes.set_ylim(-0.5, len(rows) - 0.5)
    axes.set_xlabel("work-items in x")
    axes.set_ylabel("work-items in y")
    axes.set_title("time relative to the default's; darker is slower", fontsize=9)
    axes.tick_params(length=0)


def _draw_cell(axes: Any, place: tuple[int, int], colour: str, text: str, weight: str) -> None:
    x, y = place
    axes.add_patch(Rectangle((x - 0.5, y - 0.5), 1, 1, facecolor=colour, edgecolor="black", linewidth=0.8))
    axes.text(x, y, text, ha="center", va="center", fontsize=8, weight=weight)
