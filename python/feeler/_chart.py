"""What the program's `feeler chart` runs: it has read the options, this measures, draws and writes."""

from __future__ import annotations

import dataclasses
import json
import statistics
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from . import charts, specialisation, sweep
from ._library import BAD_USAGE, IO, Error
from ._replacement import write_text
from .accuracy import PARTS, Accuracy
from .scene import Scene, load

PAIRS = 3  # of compilations
ENDINGS = (".png", ".svg", ".json", ".csv")


@dataclass(frozen=True)
class Request:
    """The options; None is what a plan has by default."""

    scenes: list[str]
    specialised: bool = False
    quick: bool = False
    quiet: bool = False
    out: str | None = None
    size: list[int] | None = None
    repeat: int | None = None
    truth_samples: int | None = None
    device: str | None = None

    def plan(self) -> sweep.Plan:
        given = {
            "size": tuple(self.size) if self.size else None,
            "repeat": self.repeat,
            "truth_samples": self.truth_samples,
        }
        chosen: dict[str, Any] = {name: value for name, value in given.items() if value is not None}
        return dataclasses.replace(sweep.QUICK if self.quick else sweep.Plan(), **chosen)


def main(text: str) -> int:
    """Does what a request (JSON) says; gives the program's exit code."""
    try:
        request = Request(**json.loads(text))
        (_chart_specialisation if request.specialised else _chart_accuracy)(request)
    except Error as error:
        print(f"feeler: {error}", file=sys.stderr)
        return 2 if error.kind == "bad usage" else 130 if error.kind == "interrupted" else 1
    except OSError as error:
        print(f"feeler: {error.filename or 'output'}: {error.strerror}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("feeler: interrupted; of what is not finished nothing is written", file=sys.stderr)
        return 130
    return 0


def _chart_accuracy(request: Request) -> None:
    names = [Path(path).stem for path in request.scenes]
    bases = _bases(request.out, names, "accuracy-{name}")
    scenes = [_load(path) for path in request.scenes]
    for path, name, scene, base in zip(request.scenes, names, scenes, bases, strict=True):
        with _progress(path, request.quiet) as say:
            results = sweep.measure(scene, request.plan(), name=name, device=request.device, say=say)
        _write(base, results.to_json(), results.to_csv())
        charts.accuracy(results, save=f"{base}.png")
        if not request.quiet:
            print(format_table(results), f"written: {base}{{{','.join(ENDINGS)}}}", sep="\n", flush=True)


def _chart_specialisation(request: Request) -> None:
    base = _bases(request.out, ["specialised"], "{name}")[0]
    for path in request.scenes:
        _load(path)
    plan, results = request.plan(), []
    for path in request.scenes:
        with _progress(path, request.quiet) as say:
            one = specialisation.measure(
                path, size=plan.size, repeat=request.repeat or PAIRS, device=request.device, say=say
            )
        results.append(one)
        if not request.quiet:
            print(format_line(one), flush=True)
    _write(base, specialisation.to_json(results), specialisation.to_csv(results))
    charts.specialisation(results, save=f"{base}.png")
    if not request.quiet:
        print(f"written: {base}{{{','.join(ENDINGS)}}}")


# ---- files ----


def _load(path: str) -> Scene:
    """Before time is spent on any, so that what is wrong is told at once."""
    scene = load(path)
    for warning in scene.warnings:
        print(f"feeler: warning: {warning}", file=sys.stderr)
    return scene


def _bases(out: str | None, names: Sequence[str], default: str) -> list[str]:
    """Where each chart goes, without ending: `out` is a folder or a pattern."""
    pattern = out or default
    if pattern.endswith("/") or Path(pattern).is_dir():
        pattern = str(Path(pattern) / default)
    if len(names) > 1 and "{name}" not in pattern:
        raise Error("--out must contain {name}, or be a folder: there are several scenes", code=BAD_USAGE)
    if len(set(names)) < len(names):
        raise Error("several scenes have the same name", code=BAD_USAGE)
    bases = [pattern.replace("{name}", name) for name in names]
    bases = [base[: -len(ending)] if (ending := Path(base).suffix) in ENDINGS else base for base in bases]
    for base in bases:
        folder = Path(base).parent
        try:
            tempfile.TemporaryFile(dir=folder).close()
        except OSError as error:
            raise Error(f"cannot write into the folder '{folder}': {error.strerror}", source=base, code=IO) from None
    return bases


def _write(base: str, as_json: str, as_csv: str) -> None:
    for ending, text in ((".json", as_json), (".csv", as_csv)):
        write_text(base + ending, text)


# ---- what is said ----


@contextmanager
def _progress(path: str, quiet: bool) -> Iterator[sweep.Say]:
    """Shows on a terminal what is under way."""
    shown = not quiet and sys.stderr.isatty()

    def say(text: str) -> None:
        if shown:
            print(f"\r\033[K{path}: {text}", end="", file=sys.stderr, flush=True)

    try:
        yield say
    finally:
        if shown:
            print("\r\033[K", end="", file=sys.stderr, flush=True)


def format_table(results: Accuracy) -> str:
    """A line for each setting, the fastest first."""
    truth, front = results.truth, results.front
    columns = "{:<4}{:<23}{:>10}{:>20}{:>11}{:>11}{:>9}{:>12}{:>11}".format
    lines = [
        f"{results.scene}, {results.size[0]} x {results.size[1]}; noise of the truth {truth.noise:.1e}",
        columns("", "setting", "time, ms", "quartiles", "error", "precision", "flips", "truncation", "sampling"),
    ]
    for place in sorted(range(len(results.points)), key=lambda place: results.points[place].median):
        point = results.points[place]
        low, high = point.quartiles
        parts = [f"{getattr(point, part).rmse:.2e}" for part in PARTS]
        parts.insert(PARTS.index("precision") + 1, f"{100 * point.precision.flips:.2f} %")
        marks = "*" * point.default + "F" * (place in front)
        times = (f"{1000 * point.median:.2f}", f"{1000 * low:.2f} … {1000 * high:.2f}")
        lines.append(columns(marks, point.setting.name, *times, *parts))
    lines += [f"left out: {name}, {why}" for name, why in results.left_out.items()]
    return "\n".join([*lines, "*: the default; F: on the Pareto front"])


def format_line(one: specialisation.Specialisation) -> str:
    """What a scene's own kernels take against general ones."""
    said = []
    for part in ("trace", "compile"):
        own, general = one.medians(part)
        said.append(f"{part} {general:.3f} → {own:.3f} s, {statistics.median(one.ratios(part)):.2f}")
    return f"{one.scene}: {'; '.join(said)} of the time"
