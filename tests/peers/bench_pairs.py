"""Statistics of measurements that are made in pairs, in turn: noise that lasts longer than a pair leaves their ratio alone."""

from __future__ import annotations

import statistics
from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True)
class Spread:
    """The median of some numbers, and the quartiles below and above it."""

    low: float
    median: float
    high: float


def spread(numbers: list[float]) -> Spread:
    """Quartiles are those of the sample itself: interpolated between its numbers, never beyond them."""
    if len(numbers) == 1:
        return Spread(numbers[0], numbers[0], numbers[0])
    return Spread(*statistics.quantiles(numbers, n=4, method="inclusive"))


@dataclass(frozen=True)
class Pairs:
    """Seconds of ours and of theirs, each pair measured one right after the other."""

    ours: list[float]
    theirs: list[float]

    @property
    def times_faster(self) -> Spread:
        """How many times as long theirs takes: the spread of the pairs' ratios."""
        return spread([theirs / ours for ours, theirs in zip(self.ours, self.theirs, strict=True)])


def measure_pairs(ours: Callable[[], float], theirs: Callable[[], float], count: int) -> Pairs:
    """Runs both in turn: A B A B … Each function measures once and returns seconds."""
    pairs = Pairs([], [])
    for _ in range(count):
        pairs.ours.append(ours())
        pairs.theirs.append(theirs())
    return pairs
