#!/usr/bin/env python3
"""How far a kernel's traversal is from its limit: how often it takes each step, times what the step costs alone.

    limit.py [SCENE…]

Without arguments: SPD balls, tetra and mount, at one sample (one ray at a time) and at 16 (a packet). `make limit` runs
this. Times are of the process, not of the clock, on one thread, and the least of several runs. What spares ways through the
tree is left out, so that each ray has its own: pixels that see nothing send their rays, feelers go one by one.
"""

from __future__ import annotations

import os
import re
import sys
import time
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

os.environ["POCL_MAX_PTHREAD_COUNT"] = "1"  # before the driver is loaded

from bench_programs import classic

import feeler
from feeler._device import default_queue

SIZE, REPEAT = 512, 5
MANY, INNER = 16, 512  # as in costs.cl
FOUND = (False, True)  # whether a ray finds something

# As in kernels/count.cl and types.h.
LONE, NODES, CHILDREN, BEAMS, BOXES, TESTS, ERRANDS = 0, 1, 2, 4, 5, 6, 7
KINDS = {"sphere": 0, "triangle": 4, "polygon": 5}
ROWS = {"sphere": 10, "triangle": 9, "polygon": 6}
EACH_ITS_WAY = "-DSEND_ALL=1 -DFANS=0"


def tried(kind: str, together: bool) -> int:
    """The count of what is tried; that of what is found, and of a beam's blocks, follow it."""
    return 8 + KINDS[kind] * 8 + (0 if together else 4)


@contextmanager
def kernel_options(options: str) -> Iterator[None]:
    before = os.environ.get("FEELER_KERNEL_OPTIONS", "")
    os.environ["FEELER_KERNEL_OPTIONS"] = f"{before} {EACH_ITS_WAY} {options}"
    try:
        yield
    finally:
        os.environ["FEELER_KERNEL_OPTIONS"] = before


def seconds(work: Callable[[], Any]) -> float:
    """Of the processor."""
    start = time.process_time()
    work()
    return time.process_time() - start


# ---- how often


def render(scene: feeler.Scene, samples: int, size: int = SIZE) -> dict[str, Any]:
    return scene.render((size, size), samples, jitter=0).stats


def count_steps(scene: feeler.Scene, samples: int, kinds: list[str]) -> dict[int, int]:
    """Each count of kernels/count.cl that this scene can have."""
    together = {tried(kind, True) for kind in kinds}
    apart = {tried(kind, False) for kind in kinds} | {BEAMS} if samples > 1 else set()
    counts: dict[int, int] = {}
    for first in sorted({LONE} | together | apart):
        with kernel_options(f"-DCOUNTING={first // 4 + 1}"):
            rays = render(scene, samples)["rays"]
        found = [rays[name] for name in ("reflection", "transmission", "shadow", "eye_hits")]
        counts |= {first + i: number for i, number in enumerate(found)}
    return counts


# ---- what a step costs


def make_rays(alike: bool, found: bool) -> Any:
    """From before the origin to what is there, or past it; the lanes of a packet a little apart."""
    random = np.random.default_rng(1)
    origins = np.array((0, 0, -5)) + random.uniform(-0.1, 0.1, (MANY, 1, 3))
    targets = random.uniform(-0.1, 0.1, (MANY, 1, 3)) + (0 if found else np.array((3, 3, 0)))
    directions = targets - origins + random.uniform(-0.01, 0.01, (MANY, 1 if alike else 16, 3))
    directions /= np.linalg.norm(directions, axis=2, keepdims=True)
    both = np.concatenate([np.broadcast_to(a, (MANY, 16, 3)) for a in (origins, directions)], axis=2)
    return np.ascontiguousarray(both.swapaxes(1, 2), np.float32)


def make_blocks(kind: str, width: int) -> Any:
    """In each block one primitive is at the origin, the others are far from every ray."""
    random = np.random.default_rng(2)
    at = random.uniform(-0.1, 0.1, (MANY, 3, width)) + np.array([0] + [-20] * (width - 1))
    if kind == "triangle":
        corners = [at + np.array(c)[:, None] for c in ((-2, -1.5, 0), (2, -1.5, 0), (0, 2.5, 0))]
        return np.concatenate(corners, axis=1).astype(np.float32)
    size = 0.5 if kind == "sphere" else 1.0
    rows = [at - size, at + size]
    if kind == "sphere":
        rows += [at, np.full((MANY, 1, width), size)]
    return np.concatenate(rows, axis=1).astype(np.float32)


def make_data(kind: str, width: int) -> list[Any]:
    """What costs.cl takes before the rays."""
    random = np.random.default_rng(3)
    centres, half = random.uniform(-1, 1, (MANY, 3, width)), random.uniform(0.2, 0.8, (MANY, 3, width))
    nodes = np.concatenate([centres - half, centres + half], axis=1).astype(np.float32)
    links = np.array([(k * ROWS[kind], KINDS[kind] << 29 | MANY // width) for k in range(MANY)], np.uint32)
    masks = [sum(1 << bit for bit in random.choice(width, 3, replace=False)) for _ in range(MANY)]
    numbers = np.array(masks + list(range(width)), np.uint32)
    primitives = np.array([(KINDS[kind], 0, 0, 0)] * width, np.uint32)
    square = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)])[[3, 0, 1, 2] + [3] * (width - 3)]
    polygon = np.array([(0, 0, 0, 0), (0, 0, -1, 0), (-1, -1, 0, 0), (1, 1, 0, 0)], np.float32)
    corners = np.concatenate([square.T, np.zeros((1, width + 1))]).astype(np.float32)
    ranges = np.array([(0, 4, 0, 0)], np.uint32)
    return [nodes, links, make_blocks(kind, width), numbers, primitives, polygon, ranges, corners]


class Steps:
    """The kernels of costs.cl, built as for a scene, and the least nanoseconds that each step has taken."""

    def __init__(self, options: str, kinds: list[str]) -> None:
        import pyopencl as cl

        width = re.search(r"-DWIDTH=(\d+)", options)
        self.cl, self.queue, self.width = cl, default_queue(), int(width[1]) if width else 8
        self.kinds, self.alike = kinds, "-DRAYS=1 " in options
        source = feeler.kernel_source() + Path(__file__).with_name("costs.cl").read_text()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", cl.CompilerWarning)
            self.program = cl.Program(self.queue.context, source).build(options, cache_dir=False)
        plain = ["node", "children", "way"] + ([] if self.alike else ["boxes", "test", "errands", "beam_way"])
        each = ["block"] + ([] if self.alike else ["entry", "beam_block"])
        self.runs = {(step, kinds[0], False): self._prepare(step, kinds[0], False) for step in plain}
        for kind in kinds:
            self.runs |= {(step, kind, found): self._prepare(step, kind, found) for step in each for found in FOUND}
        self.least = dict.fromkeys(self.runs, float("inf"))

    def _prepare(self, step: str, kind: str, found: bool) -> Callable[[], float]:
        cl = self.cl
        flags = cl.mem_flags.READ_WRITE | cl.mem_flags.COPY_HOST_PTR
        given = [*make_data(kind, self.width), make_rays(self.alike, found)]
        buffers = [cl.Buffer(self.queue.context, flags, hostbuf=array) for array in given]
        out = cl.Buffer(self.queue.context, cl.mem_flags.READ_WRITE, 64)
        kernel = cl.Kernel(self.program, f"measure_{step}")

        def run(rounds: int) -> float:
            return seconds(lambda: kernel(self.queue, (1,), (1,), *buffers, np.uint32(rounds), out).wait())

        run(MANY)  # compiles
        rounds = MANY * max(1, int(0.01 / max(run(MANY), 1e-5)))
        return lambda: run(rounds) / (rounds * INNER) * 1e9

    def measure(self) -> None:
        """Once more."""
        for key, run in self.runs.items():
            self.least[key] = min(self.least[key], run())

    def costs(self) -> dict[int, float]:
        """For each count; those of what is found are what it takes more than what is only tried."""
        some = self.kinds[0]

        def least(step: str, kind: str = some, found: bool = False) -> float:
            return self.least[step, kind, found]

        costs = {NODES: least("node"), CHILDREN: least("children") / 3, LONE: least("way") - least("block")}
        for kind in self.kinds:
            first = tried(kind, True)
            costs |= {first: least("block", kind), first + 1: least("block", kind, True) - least("block", kind)}
        if self.alike:
            return costs
        costs |= {BOXES: least("boxes"), TESTS: least("test"), ERRANDS: least("errands") / 3}
        costs[BEAMS] = least("beam_way") - least("beam_block")
        for kind in self.kinds:
            first = tried(kind, False)
            costs |= {first: least("entry", kind), first + 1: least("entry", kind, True) - least("entry", kind)}
            costs[first + 2] = least("beam_block", kind)
        return costs


# ---- both


@dataclass(frozen=True)
class Limit:
    """A scene at a number of samples.

    Attributes:
        rays: that were traced.
        counts, costs: how often each step was taken, and its nanoseconds.
        traversal, rest: measured nanoseconds of a ray: finding hits, and all else.
    """

    scene: str
    samples: int
    kinds: list[str]
    rays: int
    counts: dict[int, int]
    costs: dict[int, float]
    traversal: float
    rest: float

    @property
    def product(self) -> float:
        return sum(self.counts[step] * cost for step, cost in self.costs.items()) / self.rays


def find_limit(path: Path, samples: int) -> Limit:
    scene = feeler.load(path)
    info = scene.info(samples=samples)
    kinds = [kind for kind in KINDS if kind in info["features"]]
    with kernel_options(""):
        rays = render(scene, samples)["rays"]
    total = sum(rays[name] for name in ("eye", "reflection", "transmission", "shadow"))
    steps = Steps(scene.kernel_options(samples=samples), kinds)
    once, twice, start = [], [], []
    for i in range(REPEAT + 1):  # in turn: a machine is slow for seconds
        with kernel_options(""):
            start.append(seconds(lambda: render(scene, samples, 8)))
            once.append(seconds(lambda: render(scene, samples)))
        with kernel_options("-DTRAVERSALS=2"):
            twice.append(seconds(lambda: render(scene, samples)))
        for _ in range(4):
            steps.measure()
        if i == 0:  # compiled
            once, twice, start = [], [], []
    traversal = min(twice) - min(once)
    rest = min(once) - min(start) - traversal
    counts = count_steps(scene, samples, kinds)
    return Limit(path.stem, samples, kinds, total, counts, steps.costs(), traversal / total * 1e9, rest / total * 1e9)


# ---- tables


def print_table(head: list[str], rows: list[list[str]]) -> None:
    widths = [max(map(len, column)) for column in zip(head, *rows, strict=True)]
    for row in [head, ["-" * width for width in widths], *rows]:
        print("| " + " | ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)) + " |")
    print()


def counts_row(limit: Limit) -> list[str]:
    """For each way of a packet, or of a ray where there are none."""
    ways = limit.counts[BEAMS] if limit.samples > 1 else limit.counts[LONE]

    def mean(*steps: int) -> str:
        return f"{sum(limit.counts.get(step, 0) for step in steps) / ways:.2f}"

    apart = [tried(kind, False) for kind in limit.kinds]
    together = [tried(kind, True) for kind in limit.kinds]
    many = [mean(BOXES), mean(TESTS), mean(ERRANDS), mean(*(step + 2 for step in apart)), mean(*apart)]
    return [
        limit.scene,
        str(limit.samples),
        f"{limit.rays / ways:.2f}",
        *(many if limit.samples > 1 else ["–"] * len(many)),
        mean(LONE) if limit.samples > 1 else "–",
        mean(NODES),
        mean(CHILDREN),
        mean(*together),
    ]


def times_row(limit: Limit) -> list[str]:
    """Nanoseconds of a ray."""
    quotient = f"{limit.traversal / limit.product:.2f}"
    return [f"{limit.product:.0f}", f"{limit.traversal:.0f}", quotient, f"{limit.rest:.0f}"]


def costs_row(limit: Limit) -> list[str]:
    costs, some = limit.costs, limit.kinds[0]
    apart, together = tried(some, False), tried(some, True)
    many = [BEAMS, BOXES, TESTS, ERRANDS, apart + 2, apart, apart + 1]
    return [
        limit.scene,
        str(limit.samples),
        *(f"{costs[step]:.1f}" if step in costs else "–" for step in many),
        *(f"{costs[step]:.1f}" for step in (LONE, NODES, CHILDREN, together, together + 1)),
    ]


def main() -> None:
    scenes = [Path(name) for name in sys.argv[1:]] or [classic(name) for name in ("balls", "tetra", "mount")]
    limits = []
    for scene in scenes:
        for samples in (1, 16):
            print(f"{scene.stem}, samples: {samples}", file=sys.stderr)
            limits.append(find_limit(scene, samples))
    print("How often, for each way of a ray (1 sample) or of a packet (16) through the tree; then ns of a ray:\n")
    print_table(
        ["scene", "samples", "rays", "boxes", "tests", "errands", "blocks", "primitives", "lone", "nodes", "children"]
        + ["blocks of one", "counts × costs", "traversal", "quotient", "all else"],
        [counts_row(limit) + times_row(limit) for limit in limits],
    )
    print("What each costs alone, in ns (primitives and blocks: of the scene's most usual kind; + what is found):\n")
    print_table(
        ["scene", "samples", "way", "boxes", "test", "errand", "block", "primitive", "+", "lone", "node", "child"]
        + ["block of one", "+"],
        [costs_row(limit) for limit in limits],
    )


if __name__ == "__main__":
    main()
