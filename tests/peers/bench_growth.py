"""The row of growth: how trace time, build time and memory grow with the number of primitives."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from bench_pairs import spread
from bench_programs import FEELER, FOLDER, MissingError, Run, run, run_embree, run_feeler, trace_seconds
from bench_rows import Plan, Result
from growth_chart import draw

SIZE = 1024
KINDS = ("spheres", "field")
NUMBERS = [10**k for k in range(3, 8)]
RESULTS = FOLDER / "growth.json"
CHART = FOLDER / "growth.svg"


@dataclass(frozen=True)
class Point:
    """What one scene took, seconds and bytes: ours, and theirs where they can be measured.

    `device_bytes` is what the device holds, `peak_bytes` the most that the process did.
    """

    kind: str
    primitives: int
    trace: list[float]
    load: float
    tree: float
    device_bytes: int
    peak_bytes: int
    their_trace: float | None
    their_build: float | None
    their_peak_bytes: int | None


def _write(kind: str, count: int) -> dict[str, Any]:
    """In a process of its own: what it holds at its peak would count as that of the children of this one."""
    return run([sys.executable, Path(__file__).with_name("growth_scenes.py"), kind, FOLDER, str(count)]).said


def _theirs(scene: dict[str, Any]) -> Run | None:
    mesh = Path(scene["mesh"]) if scene["mesh"] else None
    try:
        return run_embree(Path(scene["theirs"]), SIZE, 1, "1", mesh, frames=2)
    except MissingError:
        return None


def measure(kind: str, count: int, repeat: int) -> Point:
    """The scene's files, of up to 440 MB, are removed afterwards."""
    scene = _write(kind, count)
    ours = Path(scene["ours"])
    run_feeler(ours, 64)  # compiles
    runs = [run_feeler(ours, SIZE) for _ in range(repeat)]
    theirs = _theirs(scene)
    info = run([FEELER, "info", ours, "--json"]).said
    for name in ("ours", "theirs", "mesh"):
        if scene[name]:
            Path(scene[name]).unlink(missing_ok=True)
    return Point(
        kind,
        scene["primitives"],
        [trace_seconds(one) for one in runs],
        spread([one.said["seconds"]["load"] for one in runs]).median,
        spread([one.said["seconds"]["tree"] for one in runs]).median,
        info["memory_bytes"]["total"],
        max(one.peak_bytes for one in runs),
        trace_seconds(theirs) if theirs else None,
        theirs.said["build_s"] if theirs else None,
        theirs.peak_bytes if theirs else None,
    )


def _describe(p: Point) -> str:
    text = (
        f"load {p.load:.2f} s, tree {p.tree:.2f} s, peak {p.peak_bytes / 2**30:.2f} GiB, "
        f"device {p.device_bytes / p.primitives:.0f} bytes a primitive"
    )
    if p.their_build is not None and p.their_peak_bytes is not None:
        text += f"; Embree: build {p.their_build:.2f} s, peak {p.their_peak_bytes / 2**30:.2f} GiB"
    return text


def _results(kind: str, points: list[Point]) -> Iterator[Result]:
    for p in points:
        trace = spread(p.trace)
        case = f"{kind}, 10^{len(str(p.primitives + p.primitives // 9)) - 1}"
        yield Result("growth", case, trace.median, p.their_trace, trace, "s", None, note=_describe(p))
    small, large = points[-3], points[-1]
    growth = spread([t / spread(small.trace).median for t in large.trace])
    yield Result("growth", f"{kind}, t(10^7) / t(10^5)", None, None, growth, "x", 3, None, False)
    if kind == "field":
        memory = spread([large.peak_bytes / 2**30])
        yield Result("growth", "10^7 triangles, peak", None, None, memory, "GiB", 8, None, False)


def growth(plan: Plan) -> Iterator[Result]:
    """Trace time from 10^3 to 10^7 primitives; minutes, gigabytes."""
    everything: list[dict[str, Any]] = []
    for kind in KINDS:
        points = []
        for count in NUMBERS:
            plan.say(f"growth {kind} {count:,}")
            points.append(measure(kind, count, min(plan.repeat, 3)))
            everything.append(asdict(points[-1]))
            RESULTS.write_text(json.dumps(everything, indent=1))
        yield from _results(kind, points)
    draw(everything, CHART)
