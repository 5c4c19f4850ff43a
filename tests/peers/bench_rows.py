"""The rows of the table: what is measured, against what, and what is wanted."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import bench_programs as programs
from bench_pairs import Pairs, Spread, measure_pairs, spread
from bench_programs import ROOT, classic, run_embree, run_feeler, run_frames, run_povray, trace_seconds


@dataclass(frozen=True)
class Plan:
    """How much to measure.

    Attributes:
        repeat: pairs of a row.
        quick: smaller pictures, and no growth.
        tracer: the Embree tracer.
        say: told what is under way.
    """

    repeat: int
    quick: bool
    tracer: Path
    say: Callable[[str], None]


@dataclass(frozen=True)
class Result:
    """A line of the table.

    Attributes:
        row, case: what is measured.
        ours, theirs: median seconds; theirs is None where there is no peer.
        value: what is judged, in `unit`: "x" (times faster, or a quotient) or "s".
        wanted, aim: limits of the value; None: it is only recorded.
        at_least: whether more is better.
        note: what else came out.
    """

    row: str
    case: str
    ours: float | None
    theirs: float | None
    value: Spread
    unit: str
    wanted: float | None
    aim: float | None = None
    at_least: bool = True
    note: str = ""

    @property
    def passes(self) -> bool | None:
        if self.wanted is None:
            return None
        return self.value.median >= self.wanted if self.at_least else self.value.median <= self.wanted

    def as_json(self) -> dict[str, Any]:
        return {**asdict(self), "passes": self.passes}


def times_faster(row: str, case: str, pairs: Pairs, wanted: float | None, aim: float | None, note: str = "") -> Result:
    ours, theirs = spread(pairs.ours).median, spread(pairs.theirs).median
    return Result(row, case, ours, theirs, pairs.times_faster, "x", wanted, aim, note=note)


# ---- against Embree

TRACED = ("balls", "tetra", "mount")


def one_ray(plan: Plan) -> Iterator[Result]:
    """Embree, one ray at a time: trace time, one sample, the fastest of five frames of each."""
    size = 512 if plan.quick else 1024
    for name in TRACED:
        plan.say(f"one-ray {name} {size} x {size}")
        scene = classic(name)
        for side, wanted, aim in ((1, 1.5, 2.0), (4, None, None)):
            pairs = measure_pairs(
                lambda scene=scene, side=side: trace_seconds(run_frames(scene, size, pixels=(side, side))),
                lambda scene=scene: trace_seconds(run_embree(scene, size, 1, "1", tracer=plan.tracer)),
                plan.repeat,
            )
            yield times_faster("one-ray", name if wanted else f"{name}, --pixels {side}x{side}", pairs, wanted, aim)


def best_mode(plan: Plan) -> Iterator[Result]:
    """Embree's best mode at 16 samples per pixel: trace time, the fastest of five frames of each."""
    size = 256 if plan.quick else 512
    medians = []
    for name in TRACED:
        scene = classic(name)
        tried = {}
        for mode in ("1", "16", "c"):
            plan.say(f"best-mode {name} {size} x {size}: mode {mode}")
            tried[mode] = trace_seconds(run_embree(scene, size, 16, mode, frames=2, tracer=plan.tracer))
        best = min(tried, key=lambda mode: tried[mode])
        plan.say(f"best-mode {name} {size} x {size}: against mode {best}")
        pairs = measure_pairs(
            lambda scene=scene: trace_seconds(run_frames(scene, size, 16)),
            lambda scene=scene, best=best: trace_seconds(run_embree(scene, size, 16, best, tracer=plan.tracer)),
            plan.repeat,
        )
        result = times_faster("best-mode", name, pairs, 1.6, 2.5, f"mode {best}")
        medians.append(result.value.median)
        yield result
    yield Result("best-mode", "median of the three", None, None, spread(medians), "x", 1.6, 2.5)


# ---- against POV-Ray


def pov_ray(plan: Plan) -> Iterator[Result]:
    """POV-Ray: whole process, kernel cache warm."""
    size = 512 if plan.quick else 2048
    for samples, side, wanted in ((1, 1, 6), (1, 4, None), (16, 1, 15)):
        for name in ("balls", "rings", "mount"):
            case = f"{name}, samples: {samples}" + (f", --pixels {side}x{side}" if side > 1 else "")
            plan.say(f"pov-ray {case}, {size} x {size}")
            scene, exported, pixels = classic(name), programs.write_pov(name), (side, side)
            run_feeler(scene, size, samples, pixels=pixels)
            pairs = measure_pairs(
                lambda scene=scene, samples=samples, pixels=pixels: (
                    run_feeler(scene, size, samples, pixels=pixels).seconds
                ),
                lambda scene=exported, samples=samples: run_povray(scene, size, samples).seconds,
                min(plan.repeat, 3 if samples == 16 else plan.repeat),
            )
            yield times_faster("pov-ray", case, pairs, wanted, None)


# ---- against itself


def specialised(plan: Plan) -> Iterator[Result]:
    """Itself without specialisation, on a scene that needs little: trace time, and compilation into an empty cache."""
    scene, size = classic("tetra"), 512 if plan.quick else 1024
    colds: dict[bool, list[float]] = {False: [], True: []}
    with tempfile.TemporaryDirectory() as folder:

        def trace(general: bool) -> float:
            return trace_seconds(run_frames(scene, size, general=general, cache=Path(folder)))

        plan.say(f"specialised tetra {size} x {size}")
        pairs = measure_pairs(lambda: trace(False), lambda: trace(True), plan.repeat)
    for _ in range(min(plan.repeat, 3)):
        for general, found in colds.items():
            plan.say("specialised tetra: compiling into an empty cache")
            with tempfile.TemporaryDirectory() as folder:
                run = run_frames(scene, 64, general=general, frames=1, cache=Path(folder))
                found.append(float(run.said["compile_s"]))
    yield times_faster("specialised", "tetra, trace", pairs, 1.0, None)
    yield times_faster("specialised", "tetra, first compilation", Pairs(colds[False], colds[True]), None, None)


def start(plan: Plan) -> Iterator[Result]:
    """Itself: the whole process for a picture of 64 x 64 pixels, kernel cache warm or empty."""
    scenes = [ROOT / "scenes" / "first.yaml", classic("balls")]
    for scene in scenes:
        plan.say(f"start {scene.stem}, cache warm")
        run_feeler(scene, 64)
        warm = [run_feeler(scene, 64).seconds for _ in range(plan.repeat)]
        yield Result("start", f"{scene.stem}, warm", spread(warm).median, None, spread(warm), "s", 0.4, 0.15, False)
    for scene in scenes:
        plan.say(f"start {scene.stem}, cache empty")
        cold = []
        for _ in range(min(plan.repeat, 3)):
            with tempfile.TemporaryDirectory() as folder:
                cold.append(run_feeler(scene, 64, cache=Path(folder)).seconds)
        yield Result("start", f"{scene.stem}, empty", spread(cold).median, None, spread(cold), "s", 3, None, False)


ROWS: dict[str, Callable[[Plan], Iterator[Result]]] = {
    "one-ray": one_ray,
    "best-mode": best_mode,
    "pov-ray": pov_ray,
    "specialised": specialised,
    "start": start,
}
