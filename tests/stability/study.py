"""What a study is: for one row of the catalogue, the failures of a naive method, of the robust one, and of double, over the
parameter that provokes them.
"""

from __future__ import annotations

import dataclasses
import math
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .cost import Cost, PictureCost

NAIVE, ROBUST, DOUBLE, OTHER = "naive", "robust", "double", "other"
Claim = float | Sequence[float | None] | None
ROOM = 4 / 3  # a figure in words has one digit or two, and another device may round otherwise


@dataclass(frozen=True)
class Curve:
    """What one method gave: a rate or an error for each x; None where there is nothing to measure.

    What is claimed of it: no value is above `bound`, one number or one for each x; the largest reaches `fails`, and where that is
    one for each x every value does; `figures` are those of docs/numerics.md, one for each x: a value is its figure but for a factor
    of ROOM. None is no claim. Whatever is claimed, every value is a number.
    """

    name: str
    kind: str
    values: Sequence[float | None]
    bound: Claim = None
    fails: Claim = None
    figures: Sequence[float | None] | None = None

    def claims_something(self) -> bool:
        return any(claim is not None for part in (self.bound, self.fails, self.figures) for claim in self.each(part))

    def each(self, claim: Claim) -> list[float | None]:
        """For each x."""
        claims = list(claim) if isinstance(claim, Sequence) else [claim] * len(self.values)
        assert len(claims) == len(self.values), f"{self.name}: {len(claims)} claims for {len(self.values)} values"
        return claims

    def broken_claims(self) -> list[str]:
        """What is not as claimed. What was not measured is under any bound, but it reaches nothing and is no figure."""
        measured = [value for value in self.values if value is not None]

        def holds(claim: Claim, of: Callable[[float | None, float], bool]) -> bool:
            return all(c is None or of(v, c) for v, c in zip(self.values, self.each(claim), strict=True))

        def reaches(value: float | None, least: float) -> bool:
            if not isinstance(self.fails, Sequence):
                value = max(measured, default=None)
            return value is not None and value >= least

        checks = {
            "has what is no number": not any(math.isnan(v) for v in measured),
            f"is above {self.bound}": holds(self.bound, lambda v, b: v is None or v <= b),
            f"does not reach {self.fails}": holds(self.fails, reaches),
            f"is not about {self.figures}": holds(
                self.figures, lambda v, f: v is not None and f / ROOM <= v <= f * ROOM
            ),
        }
        return [f"{self.name}: {list(self.values)} {words}" for words, as_claimed in checks.items() if not as_claimed]


@dataclass(frozen=True)
class Panel:
    """One chart: what is measured, over what. With `tries`, values are rates of so many tries."""

    title: str
    x_name: str
    x: Sequence[float | str]
    y_name: str
    curves: Sequence[Curve]
    tries: int | None = None
    x_log: bool = True
    y_log: bool = True


@dataclass(frozen=True)
class Study:
    """A row of the catalogue."""

    row: int
    name: str
    oracle: str
    run: Callable[[], list[Panel]]
    cost: Cost | PictureCost | None = None
    slow: bool = False  # because whole kernels are built

    def __str__(self) -> str:
        return f"{self.row}-{self.name.replace(' ', '-')}"


@dataclass
class Result:
    """What a study gave, as it is written to a file."""

    row: int
    name: str
    oracle: str
    panels: list[Panel]
    cost: dict[str, Any] | None = field(default=None)

    def as_dict(self) -> dict[str, Any]:
        return dataclasses.asdict(self)


def run(study: Study, with_cost: bool = True) -> Result:
    cost = study.cost.measure() if study.cost and with_cost else None
    return Result(study.row, study.name, study.oracle, study.run(), cost)


def broken_claims(result: Result) -> list[str]:
    """What is not as claimed."""
    return [
        f"{panel.title}: {words}"
        for panel in result.panels
        for curve in panel.curves
        for words in curve.broken_claims()
    ]


def between(low: float, high: float, count: int) -> dict[str, Any]:
    """The claim of so many values that they lie from `low` to `high`, with a fifth of either as room."""
    return {"fails": [0.8 * low] * count, "bound": [1.2 * high] * count}


def later(values: Sequence[float], count: int | None = None) -> dict[str, Any]:
    """What is claimed of double where digits cancel: 2²⁹ times less than these of float's, but for a factor of 8. Of the first
    `count`, where float is not lost yet.
    """
    known = [v / 2**29 if count is None or i < count else None for i, v in enumerate(values)]
    return {"bound": [k and 8 * k for k in known], "fails": [k and k / 8 for k in known]}


def rates(wrong: Sequence[Any]) -> list[float]:
    """The share of what is true in each array."""
    return [float(np.mean(w)) for w in wrong]


@contextmanager
def kernel_options(options: str) -> Iterator[None]:
    """Renders with more build options."""
    before = os.environ.get("FEELER_KERNEL_OPTIONS")
    os.environ["FEELER_KERNEL_OPTIONS"] = options
    try:
        yield
    finally:
        if before is None:
            del os.environ["FEELER_KERNEL_OPTIONS"]
        else:
            os.environ["FEELER_KERNEL_OPTIONS"] = before
