"""Runs feeler, the Embree tracer and POV-Ray, each as a process, and tells what that took."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
BUILD = ROOT / "build"
FOLDER = BUILD / "bench"  # of pictures, scenes and results
SPD = Path(os.environ.get("FEELER_SPD", ROOT.parent / "shared" / "spd"))

FEELER = BUILD / "feeler"
EMBREE = BUILD / "peers" / "embree_whitted"

Word = str | Path

# In one process, as the tracer beside it; samples are in their cells' centres, as its are.
FRAMES = """
import json, sys, feeler
options = json.loads(sys.argv[2])
frames = options.pop("frames")
scene = feeler.load(sys.argv[1])
seconds = [scene.render(jitter=0, **options).stats["seconds"] for _ in range(frames)]
print(json.dumps({"trace_s": min(s["trace"] for s in seconds), "compile_s": seconds[0]["compile"]}))
"""


@dataclass(frozen=True)
class Run:
    """What a process took: seconds by the wall clock, bytes at its peak, and what it printed as JSON."""

    seconds: float
    peak_bytes: int
    said: dict[str, Any] = field(default_factory=dict)


class MissingError(Exception):
    """Something that a measurement needs is not there."""


def run(command: list[Word], folder: Path = FOLDER, **environment: str) -> Run:
    """Runs a command to its end; what it prints should be JSON or nothing."""
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as log:
        start = time.perf_counter()
        process = subprocess.Popen(command, cwd=folder, stdout=out, stderr=log, env={**os.environ, **environment})
        try:
            _, status, used = os.wait4(process.pid, 0)
        except BaseException:
            process.kill()
            raise
        seconds = time.perf_counter() - start
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode != 0:
            log.seek(0)
            words = log.read().decode(errors="replace")[-1500:]
            raise RuntimeError(f"{' '.join(map(str, command))} failed with {process.returncode}:\n{words}")
        out.seek(0)
        text = out.read()
    return Run(seconds, used.ru_maxrss * 1024, json.loads(text) if text.strip() else {})


def run_feeler(
    scene: Path, size: int, samples: int = 1, *, pixels: tuple[int, int] = (1, 1), cache: Path | None = None
) -> Run:
    """Renders to a file. Samples are in their cells' centres, where the other renderers have theirs."""
    options = ["--size", f"{size}x{size}", "--samples", str(samples), "--jitter", "0", "--quiet", "--stats", "-"]
    options += ["--pixels", f"{pixels[0]}x{pixels[1]}"]
    environment = {"POCL_CACHE_DIR": str(cache)} if cache else {}
    return run([FEELER, "render", scene, "-o", FOLDER / "feeler.png", *options], **environment)


def trace_seconds(result: Run) -> float:
    """Of either tracer: shading included, nothing else."""
    said = result.said
    return float(said["trace_s"] if "trace_s" in said else said["seconds"]["trace"])


def run_frames(
    scene: Path,
    size: int,
    samples: int = 1,
    *,
    pixels: tuple[int, int] = (1, 1),
    general: bool = False,
    frames: int = 5,
    cache: Path | None = None,
) -> Run:
    """The fastest of some frames, as of run_embree, and the first one's compilation; `general`: compiles everything."""
    options = {"size": [size, size], "samples": samples, "pixels": pixels, "general": general, "frames": frames}
    environment = {"POCL_CACHE_DIR": str(cache)} if cache else {}
    command: list[Word] = [sys.executable, "-c", FRAMES, scene, json.dumps(options)]
    return run(command, FEELER_LIBRARY=str(BUILD), **environment)


def run_embree(
    scene: Path, size: int, samples: int, mode: str, mesh: Path | None = None, *, frames: int = 5, tracer: Path = EMBREE
) -> Run:
    """The fastest of some frames. Mode: 1 (one ray at a time), 16 (packets) or c (packets, said to be coherent)."""
    if not tracer.is_file():
        raise MissingError(f"{tracer.name} is not built: `make {tracer.relative_to(ROOT)}` needs libembree-dev")
    if tracer != EMBREE:  # a peer of the same command line, but for our own options
        return run([tracer, scene, str(size), str(samples), mode])
    extra: list[Word] = ["--mesh", mesh] if mesh else []
    return run([tracer, scene, str(size), str(samples), mode, "--frames", str(frames), *extra])


def write_pov(name: str) -> Path:
    """A classic scene for POV-Ray, from the exporter."""
    out = FOLDER / f"{name}.pov"
    run([sys.executable, Path(__file__).parent / "write_pov.py", classic(name), out])
    return out


def run_povray(scene: Path, size: int, samples: int) -> Run:
    """Renders a scene that lies in FOLDER to a file, on two threads."""
    if not shutil.which("povray"):
        raise MissingError("POV-Ray is missing: install povray")
    sampling = ["+A0.0", "+AM1", "+R4", "-J"] if samples == 16 else ["-A"]
    return run(["povray", f"+I{scene.name}", "+Opovray.png", f"+W{size}", f"+H{size}", "+WT2", "-D", "-GA", *sampling])


def classic(name: str) -> Path:
    """One of the Standard Procedural Databases."""
    path = SPD / f"{name}.nff"
    if not path.is_file():
        raise MissingError(f"there is no {path.name}: set FEELER_SPD to the folder of the classic scenes")
    return path
