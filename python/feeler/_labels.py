"""Labels beside points, none over another."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from ._figure import Figure

# Left, bottom, right, top, in pixels of the figure.
Box = tuple[float, float, float, float]

_DISTANCES = (9, 15, 22, 30, 40, 52, 66, 82)  # of a label's near edge from its point, in 1/72 inch
_ANGLES = (30, 330, 90, 270, 150, 210, 0, 180, 60, 300, 120, 240)  # the likeliest first
_NEAR = 15  # a line leads to a point that is farther off, or farther than another point
_STRANGE = 20  # square pixels that a label would rather cover than stand nearer to another's point


@dataclass(frozen=True)
class Label:
    """What stands beside a point of the axes."""

    x: float
    y: float
    text: str
    weight: str = "normal"


def place_labels(
    figure: Figure, axes: Any, labels: Sequence[Label], taken: Sequence[Box] = (), size: float = 7
) -> None:
    """Writes each label at the nearest place that neither another label nor anything taken covers.

    The figure's layout must be final: labels do not take part in it.
    """
    scale = figure.dpi / 72
    inside = axes.get_window_extent()
    points = axes.transData.transform([(label.x, label.y) for label in labels])
    occupied = list(taken)
    for label, (x, y) in zip(labels, points, strict=True):
        note = axes.annotate(
            label.text, (label.x, label.y), (0, 0), textcoords="offset points", ha="center", va="center",
            fontsize=size, weight=label.weight, annotation_clip=False,
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.7, "pad": 0.5},
        )  # fmt: skip
        note.set_in_layout(False)
        extent = note.get_window_extent()
        width, height = extent.width / 2 + 3 * scale, extent.height / 2
        best, least = None, math.inf
        for dx, dy in _places(width, height, scale):
            box = (x + dx - width, y + dy - height, x + dx + width, y + dy + height)
            cost = sum(overlap(box, other) for other in occupied) + outside(box, inside.extents)
            cost += _STRANGE * is_strange(box, (x, y), points)
            if cost < least:
                best, least = (dx, dy, box), cost
            if cost == 0:
                break
        if best is None:
            continue
        dx, dy, box = best
        occupied.append(box)
        note.set_position((dx / scale, dy / scale))
        if apart(box, (x, y)) > _NEAR * scale or is_strange(box, (x, y), points):
            _lead(axes, (x, y), box)


def _places(width: float, height: float, scale: float) -> Iterator[tuple[float, float]]:
    """Offsets of a label's centre, in pixels, the best first."""
    for far in _DISTANCES:
        for angle in _ANGLES:
            across, up = math.cos(math.radians(angle)), math.sin(math.radians(angle))
            yield across * (far * scale + width), up * (far * scale + height)


def _lead(axes: Any, point: tuple[float, float], box: Box) -> None:
    """A thin line from a point to the nearest edge of its label."""
    ends = axes.transData.inverted().transform([point, nearest(box, point)])
    axes.plot(ends[:, 0], ends[:, 1], color="0.4", linewidth=0.5, zorder=2, scalex=False, scaley=False)


def nearest(box: Box, point: Sequence[float]) -> tuple[float, float]:
    """The place in a box that is nearest to a point."""
    return min(max(point[0], box[0]), box[2]), min(max(point[1], box[1]), box[3])


def apart(box: Box, point: Sequence[float]) -> float:
    """How far a point is from a box."""
    return math.dist(nearest(box, point), point)


def is_strange(box: Box, own: Sequence[float], points: Iterable[Sequence[float]]) -> bool:
    """Whether another point is nearer to a box than its own."""
    far = apart(box, own)
    return any(apart(box, point) < far for point in points)


def overlap(one: Box, other: Box) -> float:
    """The area that two boxes share."""
    width = min(one[2], other[2]) - max(one[0], other[0])
    height = min(one[3], other[3]) - max(one[1], other[1])
    return width * height if width > 0 and height > 0 else 0.0


def outside(box: Box, room: Sequence[float]) -> float:
    """The area of a box that is not in a room."""
    area = (box[2] - box[0]) * (box[3] - box[1])
    return area - overlap(box, (room[0], room[1], room[2], room[3]))
