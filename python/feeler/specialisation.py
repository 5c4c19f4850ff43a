"""What it saves to compile no more than a scene needs: kernels of the scene's own features against those of all.

    from feeler import charts, specialisation

    results = [specialisation.measure(path) for path in ("scenes/first.yaml", "scenes/night.yaml")]
    charts.specialisation(results, save="specialisation")

Every measurement is a process of its own with an empty cache of kernels (PoCL's: `POCL_CACHE_DIR`), so that it compiles
for the first time; specialised and general take turns.
"""

from __future__ import annotations

import csv
import io
import json
import os
import statistics
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from ._library import BAD_INPUT, DEVICE, Error, lib, to_string
from .scene import load
from .sweep import kernel_seconds

FRAMES = 3  # renders of a process after the one that compiles

# Else what is in the working folder stands in for Python's own modules, from Python 3.11 on.
_SAME_MODULES = {
    "PYTHONPATH": os.pathsep.join(str(Path(folder).absolute()) for folder in sys.path),
    "PYTHONSAFEPATH": "1",
}


@dataclass(frozen=True)
class Seconds:
    """Of one process: of the trace, the median of its renders; of the first render's compilation."""

    trace: float
    compile: float


@dataclass(frozen=True)
class Specialisation:
    """A scene's pairs, each measured one right after the other.

    Attributes:
        features: that the scene needs; general kernels have all.
    """

    scene: str
    device: str
    version: str
    size: tuple[int, int]
    samples: int
    features: tuple[str, ...]
    specialised: tuple[Seconds, ...]
    general: tuple[Seconds, ...]

    def ratios(self, part: str) -> list[float]:
        """Specialised by general, pair by pair, of "trace" or "compile"."""
        pairs = zip(self.specialised, self.general, strict=True)
        return [getattr(one, part) / getattr(other, part) for one, other in pairs]

    def medians(self, part: str) -> tuple[float, float]:
        """Of the seconds, specialised and general."""
        one, other = ([getattr(s, part) for s in seconds] for seconds in (self.specialised, self.general))
        return statistics.median(one), statistics.median(other)


def measure(
    path: str | os.PathLike[str],
    *,
    size: tuple[int, int] = (128, 96),
    repeat: int = 3,
    device: str | int | None = None,
    say: Callable[[str], object] | None = None,
) -> Specialisation:
    """Renders a scene's file with kernels of its own and general ones, each `repeat` times in new processes."""
    info = load(path).info(size=size)
    found: dict[bool, list[Seconds]] = {False: [], True: []}
    used = ""
    for turn in range(repeat):
        for general, seconds in found.items():
            if say:
                say(f"{'general' if general else 'specialised'} kernels, {turn + 1} of {repeat}")
            said = _run(str(path), size, general, device)
            used = str(said["device"])
            seconds.append(Seconds(float(said["trace"]), float(said["compile"])))
    return Specialisation(
        Path(path).stem, used, to_string(lib.feeler_version()), size, info["samples"], tuple(info["features"]),
        tuple(found[False]), tuple(found[True]),
    )  # fmt: skip


def _run(path: str, size: tuple[int, int], general: bool, device: str | int | None) -> dict[str, Any]:
    request = json.dumps({"path": path, "size": size, "general": general, "device": device})
    with tempfile.TemporaryDirectory(prefix="feeler-kernels-") as folder:
        done = subprocess.run(
            [sys.executable, "-m", "feeler.specialisation", request], capture_output=True, text=True, check=False,
            env={**os.environ, **_SAME_MODULES, "POCL_CACHE_DIR": folder, "FEELER_TUNED": ""},
        )  # fmt: skip
    if done.returncode:
        last = (done.stderr.strip().splitlines() or ["it did not say why"])[-1]
        raise Error(f"a render in a process of its own failed ({done.returncode}): {last}", source=path, code=DEVICE)
    said: dict[str, Any] = json.loads(done.stdout)
    return said


def _render(request: str) -> dict[str, Any]:
    """What a process of its own does."""
    wanted = json.loads(request)
    settings = {"size": tuple(wanted["size"]), "general": wanted["general"], "device": wanted["device"]}
    scene = load(wanted["path"])
    first = scene.render(**settings).stats
    traces = [kernel_seconds(scene.render(**settings)) for _ in range(FRAMES)]
    return {"trace": statistics.median(traces), "compile": first["seconds"]["compile"], "device": first["device"]}


# ---- data ----


def to_json(results: Sequence[Specialisation]) -> str:
    """Everything, for `read`."""
    return json.dumps({"scenes": [asdict(result) for result in results]}, indent=1, ensure_ascii=False) + "\n"


def to_csv(results: Sequence[Specialisation]) -> str:
    """A table: one line for each process."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["scene", "device", "width", "height", "samples", "kernels", "round", "trace", "compile"])
    for result in results:
        head = [result.scene, result.device, *result.size, result.samples]
        for kernels, several in (("specialised", result.specialised), ("general", result.general)):
            writer.writerows([*head, kernels, turn, one.trace, one.compile] for turn, one in enumerate(several, 1))
    return text.getvalue()


def read(results: str | os.PathLike[str] | Mapping[str, Any]) -> list[Specialisation]:
    """What `to_json` wrote: a file, or its content."""
    source = "" if isinstance(results, Mapping) else os.fspath(results)
    try:
        content = results if isinstance(results, Mapping) else json.loads(Path(source).read_text(encoding="utf-8"))
        return [_build(one) for one in content["scenes"]]
    except OSError as error:
        raise Error(f"cannot be read: {error.strerror}", source=source, code=BAD_INPUT) from None
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise Error(f"no results of `feeler chart --specialised` ({error!r})", source=source, code=BAD_INPUT) from None


def _build(one: Mapping[str, Any]) -> Specialisation:
    specialised, general = (
        tuple(Seconds(float(s["trace"]), float(s["compile"])) for s in one[kernels])
        for kernels in ("specialised", "general")
    )
    if not specialised or len(specialised) != len(general):
        raise ValueError("no pairs")
    size, features = tuple(map(int, one["size"])), tuple(map(str, one["features"]))
    result = {**one, "size": size, "features": features, "specialised": specialised, "general": general}
    return Specialisation(**result)


if __name__ == "__main__":
    print(json.dumps(_render(sys.argv[1])))
