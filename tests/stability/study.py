"""What a study is: for one row of the catalogue, the failures of a naive method, of the robust one, and of double, over the
parameter that provokes them.
"""

from __future__ import annotations

import dataclasses
import os
import statistics
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from shapes import only

import feeler

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
class Cost:
    """What runs in the robust and in the naive build, for the ratio of their times: statements of OpenCL C that set OUT from
    IN(0), IN(1), ..., and the inputs, a row for each.
    """

    what: str
    naive: str  # build options
    code: str
    inputs: Callable[[np.random.Generator, int], Sequence[Any]]
    features: tuple[str, ...] = ()


@dataclass(frozen=True)
class Study:
    """A row of the catalogue."""

    row: int
    name: str
    oracle: str
    run: Callable[[], list[Panel]]
    cost: Cost | None = None
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
    cost = measure(study.cost) if study.cost and with_cost else None
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


# ---- the cost of a remedy

LANES, GROUPS, REPEATS, PAIRS = 8, 1024, 20, 15
_KERNEL = """
#define IN(k) in[(k) * get_global_size(0) + get_global_id(0)]
#define OUT out[get_global_id(0)]
#define IN3(k) make_vectors(IN(k), IN(k + 1), IN(k + 2))
kernel void cost(global const reals *in, global reals *out) { %s }
"""


def measure(cost: Cost) -> dict[str, Any]:
    """Times of the robust build over those of the naive one, from pairs run in turn: median and quartiles."""
    import pyopencl as cl

    from feeler._device import default_queue

    queue = default_queue()
    rng = np.random.default_rng(1)
    rows = np.stack([np.broadcast_to(row, GROUPS * LANES) for row in cost.inputs(rng, GROUPS * LANES)])
    given = cl.Buffer(queue.context, cl.mem_flags.COPY_HOST_PTR, hostbuf=rows.astype(np.float32))
    taken = cl.Buffer(queue.context, cl.mem_flags.WRITE_ONLY, 4 * GROUPS * LANES)
    timed = cl.CommandQueue(queue.context, properties=cl.command_queue_properties.PROFILING_ENABLE)
    kernels = [_build(queue.context, cost, options) for options in ("", cost.naive)]

    def seconds(kernel: Any) -> float:
        events = [kernel(timed, (GROUPS,), (64,), given, taken) for _ in range(REPEATS)]
        timed.finish()
        return 1e-9 * sum(event.profile.end - event.profile.start for event in events)

    for kernel in kernels:
        seconds(kernel)
    pairs = [(seconds(kernels[0]), seconds(kernels[1])) for _ in range(PAIRS)]
    low, middle, high = statistics.quantiles([robust / naive for robust, naive in pairs], n=4)
    calls = GROUPS * LANES * REPEATS
    nanoseconds = [1e9 * statistics.median(times) / calls for times in zip(*pairs, strict=True)]
    return {"what": cost.what, "ratio": middle, "low": low, "high": high, "robust_ns": nanoseconds[0],
            "naive_ns": nanoseconds[1]}  # fmt: skip


def _build(context: Any, cost: Cost, options: str) -> Any:
    import pyopencl as cl

    built = f"{feeler.kernel_options(lanes=LANES, samples=LANES)} {only(*cost.features)} {options}"
    program = cl.Program(context, feeler.kernel_source() + _KERNEL % cost.code)
    return cl.Kernel(program.build(built, cache_dir=False), "cost")
