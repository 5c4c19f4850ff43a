"""What a remedy costs: the robust method's time over the naive one's, from pairs run in turn."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from shapes import only

import feeler

LANES, GROUPS, REPEATS, PAIRS = 8, 1024, 20, 15
_KERNEL = """
#define IN(k) in[(k) * get_global_size(0) + get_global_id(0)]
#define OUT out[get_global_id(0)]
#define IN3(k) make_vectors(IN(k), IN(k + 1), IN(k + 2))
kernel void cost(global const reals *in, global reals *out) { %s }
"""


@dataclass(frozen=True)
class Cost:
    """What runs in the robust and in the naive build: statements of OpenCL C that set OUT from IN(0), IN(1), ..., and the
    inputs, a row for each.
    """

    what: str
    naive: str  # build options
    code: str
    inputs: Callable[[np.random.Generator, int], Sequence[Any]]
    features: tuple[str, ...] = ()

    def measure(self) -> dict[str, Any]:
        """The ratio's median and quartiles, and the nanoseconds of one call."""
        import pyopencl as cl

        from feeler._device import default_queue

        queue = default_queue()
        rng = np.random.default_rng(1)
        rows = np.stack([np.broadcast_to(row, GROUPS * LANES) for row in self.inputs(rng, GROUPS * LANES)])
        given = cl.Buffer(queue.context, cl.mem_flags.COPY_HOST_PTR, hostbuf=rows.astype(np.float32))
        taken = cl.Buffer(queue.context, cl.mem_flags.WRITE_ONLY, 4 * GROUPS * LANES)
        timed = cl.CommandQueue(queue.context, properties=cl.command_queue_properties.PROFILING_ENABLE)
        kernels = [self._build(queue.context, options) for options in ("", self.naive)]

        def seconds(kernel: Any) -> float:
            events = [kernel(timed, (GROUPS,), (64,), given, taken) for _ in range(REPEATS)]
            timed.finish()
            return 1e-9 * sum(event.profile.end - event.profile.start for event in events)

        calls = GROUPS * LANES * REPEATS
        return _compare(self.what, lambda: seconds(kernels[0]) / calls, lambda: seconds(kernels[1]) / calls)

    def _build(self, context: Any, options: str) -> Any:
        import pyopencl as cl

        built = f"{feeler.kernel_options(lanes=LANES, samples=LANES)} {only(*self.features)} {options}"
        program = cl.Program(context, feeler.kernel_source() + _KERNEL % self.code)
        return cl.Kernel(program.build(built, cache_dir=False), "cost")


@dataclass(frozen=True)
class PictureCost:
    """Renders of what a remedy changes, with it and without: where no single function bears the cost."""

    what: str
    robust: Callable[[], feeler.Image]
    naive: Callable[[], feeler.Image]

    def measure(self) -> dict[str, Any]:
        """The ratio's median and quartiles, and the nanoseconds of tracing an eye ray with all that comes of it."""

        def seconds(image: feeler.Image) -> float:
            height, width = image.pixels.shape[:2]
            return float(image.stats["seconds"]["trace"]) / (height * width * image.stats["samples"])

        return _compare(self.what, lambda: seconds(self.robust()), lambda: seconds(self.naive()))


def _compare(what: str, robust: Callable[[], float], naive: Callable[[], float]) -> dict[str, Any]:
    robust()  # what is compiled and loaded at first is not counted
    naive()
    pairs = [(robust(), naive()) for _ in range(PAIRS)]
    low, middle, high = statistics.quantiles([a / b for a, b in pairs], n=4)
    nanoseconds = [1e9 * statistics.median(times) for times in zip(*pairs, strict=True)]
    return {"what": what, "ratio": middle, "low": low, "high": high,
            "robust_ns": nanoseconds[0], "naive_ns": nanoseconds[1]}  # fmt: skip
