"""What a study is: for one row of the catalogue, the failures of a naive method, of the robust one, and of double, over the
parameter that provokes them.
"""

from __future__ import annotations

import dataclasses
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .cost import Cost, PictureCost

NAIVE, ROBUST, DOUBLE, OTHER = "naive", "robust", "double", "other"


@dataclass(frozen=True)
class Curve:
    """What one method gave: a rate or an error for each x; None where there is nothing to measure.

    What is claimed of it: no value is above `bound` (one number, or one for each x); the largest is at least `fails`.
    """

    name: str
    kind: str
    values: Sequence[float | None]
    bound: float | Sequence[float] | None = None
    fails: float | None = None


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
    broken = []
    for panel in result.panels:
        for curve in panel.curves:
            values = np.array(curve.values, float)
            measured = np.array([value is not None for value in curve.values])
            if curve.bound is not None and not (values <= np.array(curve.bound, float))[measured].all():
                broken.append(f"{panel.title}: {curve.name}: {list(values)} is above {curve.bound}")
            if curve.fails is not None and not np.nanmax(values) >= curve.fails:
                broken.append(f"{panel.title}: {curve.name}: never reaches {curve.fails}: {list(values)}")
    return broken


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
