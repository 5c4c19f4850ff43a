"""How exact a picture is for the time that it takes: settings and methods measured against level reference.

    from feeler import charts, sweep

    results = sweep.measure("scenes/first.yaml")        # an Accuracy; takes minutes
    charts.accuracy(results, save="first")              # first.png and first.svg
    Path("first.json").write_text(results.to_json())    # for accuracy.read, and charts

A setting's error is its difference from the *truth*: level reference with many samples and less cutoff. It has three
parts, each measured alone by pictures of the same samples:

    precision     what the level computes, against level reference with all else alike
    truncation    that, against the scene's depth and the truth's cutoff
    sampling      that, against the truth

Pictures are compared in linear colours, clamped to 0 … 1.
"""

from __future__ import annotations

import csv
import io
import json
import os
import statistics
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy.typing as npt

from ._library import BAD_INPUT, Error
from .compare import compare

Pixels = npt.NDArray[Any]

PARTS = ("error", "precision", "truncation", "sampling")


@dataclass(frozen=True)
class Difference:
    """How far one picture is from another.

    Attributes:
        rmse: root of the mean square over pixels and channels.
        p999: the 99.9th percentile of the pixels' differences, each in its worst channel.
        flips: share of the pixels that are off by more than 1/255: they met another surface.
        values: the rmse of the other pixels alone.
    """

    rmse: float
    p999: float
    flips: float
    values: float


def difference(one: Pixels, other: Pixels) -> Difference:
    """Compares two pictures of linear RGB or RGBA as `feeler.compare`; alpha does not count."""
    found = compare(one[..., :3], other[..., :3])
    return Difference(rmse=found.rmse, p999=found.p999, flips=found.share, values=found.value_rmse)


@dataclass(frozen=True)
class Setting:
    """One way to render.

    Attributes:
        factor: what it varies of the default: "level" (and samples), "depth", "cutoff" or "method".
        method: one of `sweep.METHODS`, or "" for the usual ones.
    """

    factor: str
    level: str
    samples: int
    depth: int
    cutoff: float
    method: str = ""

    @property
    def name(self) -> str:
        """Short, for tables and charts."""
        names = {
            "level": f"{self.level} {self.samples}",
            "depth": f"depth {self.depth}",
            "cutoff": f"cutoff {self.cutoff:g}",
        }
        return names.get(self.factor, self.method)


@dataclass(frozen=True)
class Point:
    """What a setting took, and how far its picture is off.

    Attributes:
        default: whether it is what `feeler render` does unasked.
        seconds: the kernel's own time in each round.
        compile: seconds to build its kernels, as far as the driver did not have them.
        error, precision, truncation, sampling: see this module.
    """

    setting: Setting
    default: bool
    seconds: tuple[float, ...]
    compile: float
    error: Difference
    precision: Difference
    truncation: Difference
    sampling: Difference

    @property
    def median(self) -> float:
        """Of the seconds."""
        return statistics.median(self.seconds)

    @property
    def quartiles(self) -> tuple[float, float]:
        """Of the seconds; between the rounds themselves, never beyond them."""
        if len(self.seconds) == 1:
            return self.seconds[0], self.seconds[0]
        low, _, high = statistics.quantiles(self.seconds, n=4, method="inclusive")
        return low, high


@dataclass(frozen=True)
class Truth:
    """What errors are measured against: the mean of two pictures with different samples.

    Attributes:
        samples: of the two.
        noise: the estimated rmse of their mean: half of their difference's.
        discarded: mean weight of the rays that its own depth and cutoff did not let go.
    """

    samples: tuple[int, int]
    depth: int
    cutoff: float
    noise: float
    discarded: float


@dataclass(frozen=True)
class Accuracy:
    """All that was measured of a scene.

    Attributes:
        left_out: settings that were not measured, and why.
    """

    scene: str
    device: str
    version: str
    size: tuple[int, int]
    truth: Truth
    points: tuple[Point, ...]
    left_out: Mapping[str, str]

    @property
    def front(self) -> list[int]:
        """The points that none beats in both time and error, by place, the fastest first."""
        return self.front_by("rmse")

    def front_by(self, metric: str) -> list[int]:
        """The same by another number of the error. Its third digit does not count: nobody would wait for it."""
        return pareto_front([(point.median, float(f"{getattr(point.error, metric):.1e}")) for point in self.points])

    def to_json(self) -> str:
        """Everything, for `read`."""
        return json.dumps(asdict(self), indent=1, ensure_ascii=False) + "\n"

    def to_csv(self) -> str:
        """A table: one line for each setting, seconds as quartiles."""
        front, text = self.front, io.StringIO()
        rows = [{"scene": self.scene, **_row(point, place in front)} for place, point in enumerate(self.points)]
        writer = csv.DictWriter(text, rows[0] if rows else (), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
        return text.getvalue()


def _row(point: Point, on_front: bool) -> dict[str, Any]:
    low, high = point.quartiles
    parts = {f"{part}_{name}": value for part in PARTS for name, value in asdict(getattr(point, part)).items()}
    return {
        "name": point.setting.name, **asdict(point.setting), "default": int(point.default), "front": int(on_front),
        "rounds": len(point.seconds), "low": low, "median": point.median, "high": high, "compile": point.compile,
        **parts,
    }  # fmt: skip


def pareto_front(points: Sequence[tuple[float, float]]) -> list[int]:
    """The places of the points that no other beats: none is less in one number and at most as much in the other.

    Sorted by the first number. Of points that are alike in both, all are there.
    """
    order = sorted(range(len(points)), key=lambda place: points[place])
    front: list[int] = []
    for place in order:
        least = points[front[-1]] if front else (0.0, float("inf"))
        if points[place][1] < least[1] or points[place] == least:
            front.append(place)
    return front


# ---- reading ----


def read(results: str | os.PathLike[str] | Mapping[str, Any]) -> Accuracy:
    """What `to_json` wrote: a file, or its content."""
    source = "" if isinstance(results, Mapping) else os.fspath(results)
    try:
        content = results if isinstance(results, Mapping) else json.loads(Path(source).read_text(encoding="utf-8"))
        return _build(content)
    except OSError as error:
        raise Error(f"cannot be read: {error.strerror}", source=source, code=BAD_INPUT) from None
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise Error(f"no results of `feeler chart` ({error!r})", source=source, code=BAD_INPUT) from None


def _build(content: Mapping[str, Any]) -> Accuracy:
    points = tuple(
        Point(
            setting=Setting(**one["setting"]),
            default=bool(one["default"]),
            seconds=tuple(map(float, one["seconds"])),
            compile=float(one["compile"]),
            error=Difference(**one["error"]),
            precision=Difference(**one["precision"]),
            truncation=Difference(**one["truncation"]),
            sampling=Difference(**one["sampling"]),
        )
        for one in content["points"]
    )
    if not all(point.seconds for point in points):
        raise ValueError("a setting without times")
    truth = content["truth"]
    return Accuracy(
        scene=str(content["scene"]),
        device=str(content["device"]),
        version=str(content["version"]),
        size=(int(content["size"][0]), int(content["size"][1])),
        truth=Truth(**{**truth, "samples": (int(truth["samples"][0]), int(truth["samples"][1]))}),
        points=points,
        left_out=dict(content["left_out"]),
    )
