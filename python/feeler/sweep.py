"""What charts of accuracy vary, and the measuring itself.

A sweep is not every combination: level with samples, and else one thing at a time around the scene's own settings.
"""

from __future__ import annotations

import os
import statistics
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from . import accuracy
from ._device import LEVELS
from ._library import lib, to_string
from .accuracy import Accuracy, Difference, Pixels, Point, Setting, Truth, difference
from .image import Image
from .scene import Scene, load

Say = Callable[[str], object]


@dataclass(frozen=True)
class Method:
    """Another way to compute the same thing.

    Attributes:
        render: settings of `Scene.render`.
        build: the kernels' build options.
        samples: where it is compared; None: at the scene's own number.
        needs: without any of these features (see `feeler info`) it changes nothing, and is left out.
    """

    render: Mapping[str, Any] = field(default_factory=dict)
    build: str = ""
    samples: int | None = None
    needs: tuple[str, ...] = ()


# Every switch that charts compare, by the name that stands beside its point.
METHODS: dict[str, Method] = {
    "general": Method(render={"general": True}),
    "brute force": Method(render={"brute_force": True}),
    "1 lane": Method(render={"lanes": 1}),
    "8 lanes": Method(render={"lanes": 8}),
    "16 lanes": Method(render={"lanes": 16}),
    "rays alone": Method(build="-DFEW=17", needs=("tree",)),
    "4×4 pixels, 1 sample": Method(render={"pixels": (4, 4)}, samples=1),
    "2×2 pixels, 4 samples": Method(render={"pixels": (2, 2)}, samples=4),
    # What textbooks do (kernels/naive.cl).
    "naive sphere": Method(build="-DNAIVE_SPHERE", needs=("sphere",)),
    "naive cone": Method(build="-DNAIVE_CONE", needs=("cone",)),
    "Möller–Trumbore": Method(build="-DNAIVE_TRIANGLE", needs=("triangle",)),
    "plain edges": Method(build="-DNAIVE_EDGES", needs=("triangle",)),
    "fixed offset": Method(build="-DNAIVE_OFFSET=1e-4", needs=("shadows", "reflection", "transmission")),
    "library's pow": Method(build="-DNAIVE_POW", needs=("specular", "specular_transmission")),
}

CUTOFFS = (0.1, 0.03, 0.01, 0.003, 0.001)
FINER = 16  # how much less the truth's cutoff is
SHORT = 0.05  # seconds


@dataclass(frozen=True)
class Plan:
    """How much to measure.

    Attributes:
        repeat: rounds; every setting is rendered once in each.
        truth_samples: of both halves of the truth together, about.
        patience: seconds; a setting whose first render takes longer to trace is left out.
    """

    size: tuple[int, int] = (128, 96)
    repeat: int = 5
    truth_samples: int = 256
    samples: tuple[int, ...] = (1, 4, 16, 64)
    levels: tuple[str, ...] = LEVELS
    methods: Mapping[str, Method] = field(default_factory=lambda: METHODS)
    patience: float = 30.0


QUICK = Plan(size=(64, 48), repeat=3, truth_samples=64, samples=(1, 4, 16))


def halves(samples: int) -> tuple[int, int]:
    """Two unequal squares that are about as many together: their samples lie in different cells."""
    side = max(1, round((samples / 2) ** 0.5 - 0.5))
    return side**2, (side + 1) ** 2


@contextmanager
def _environment(build: str) -> Iterator[None]:
    """Kernels with these build options beside the caller's own, and work groups that are chosen and not kept."""
    before = {name: os.environ.get(name) for name in ("FEELER_KERNEL_OPTIONS", "FEELER_TUNED")}
    options = " ".join(filter(None, [before["FEELER_KERNEL_OPTIONS"], build]))
    os.environ["FEELER_TUNED"] = ""
    if options:
        os.environ["FEELER_KERNEL_OPTIONS"] = options
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                os.environ.pop(name, None)
            else:
                os.environ[name] = value


class _Sweep:
    """A scene under measurement."""

    def __init__(self, scene: Scene, plan: Plan, device: str | int | None, say: Say) -> None:
        self.scene, self.plan, self.device, self.say = scene, plan, device, say
        self.firsts: dict[Setting, Image] = {}
        self.left_out: dict[str, str] = {}
        info = scene.info(size=plan.size)
        self.features = set(info["features"])
        self.default = Setting("level", "standard", info["samples"], info["depth"], info["cutoff"])
        self.twins: dict[tuple[int, int, float], Pixels] = {}

    # ---- what to render ----

    def settings(self) -> list[Setting]:
        """The default first."""
        own, plan = self.default, self.plan
        counts = sorted({*plan.samples, own.samples})
        found = [own, *(Setting("level", level, n, own.depth, own.cutoff) for level in plan.levels for n in counts)]
        if self.features & {"reflection", "transmission"}:
            depths = sorted({1, 2, 3, 4, own.depth // 2})
            found += [Setting("depth", own.level, own.samples, n, own.cutoff) for n in depths if 0 < n < own.depth]
            cutoffs = [weight for weight in CUTOFFS if weight != own.cutoff and weight >= own.cutoff / 8]
            found += [Setting("cutoff", own.level, own.samples, own.depth, weight) for weight in cutoffs]
        found += [
            Setting("method", own.level, method.samples or own.samples, own.depth, own.cutoff, name)
            for name, method in plan.methods.items()
        ]
        return [setting for setting in dict.fromkeys(found) if self._matters(setting)]

    def _matters(self, setting: Setting) -> bool:
        """Whether a method makes other kernels than usual."""
        if not setting.method:
            return True
        needs = self._method(setting).needs
        usual = Setting("level", setting.level, setting.samples, setting.depth, setting.cutoff)
        return not (needs and self.features.isdisjoint(needs)) and self._options(setting) != self._options(usual)

    def _method(self, setting: Setting) -> Method:
        return self.plan.methods[setting.method] if setting.method else Method()

    def _arguments(self, setting: Setting) -> dict[str, Any]:
        own = {name: getattr(setting, name) for name in ("level", "samples", "depth", "cutoff")}
        return {"size": self.plan.size, **own, **self._method(setting).render}

    def _options(self, setting: Setting) -> str:
        with _environment(self._method(setting).build):
            return self.scene.kernel_options(**self._arguments(setting))

    # ---- rendering ----

    def render(self, setting: Setting, patience: float | None = None) -> Image:
        begin: list[float] = []

        def is_late(done: float) -> bool:
            if done > 0 and not begin:  # the first launch is back: nothing more is compiled
                begin.append(time.monotonic())
            return patience is not None and bool(begin) and time.monotonic() - begin[0] > patience

        with _environment(self._method(setting).build):
            return self.scene.render(device=self.device, progress=is_late, **self._arguments(setting))

    def twin(self, samples: int, depth: int, cutoff: float) -> Pixels:
        """The picture at level reference."""
        key = (samples, depth, cutoff)
        if key not in self.twins:
            self.say(f"reference {samples}, depth {depth}, cutoff {cutoff:g}")
            self.twins[key] = self.render(Setting("level", "reference", *key)).pixels
        return self.twins[key]

    # ---- measuring ----

    def first_renders(self) -> None:
        """Compiles, and keeps the pictures."""
        for setting in self.settings():
            self.say(setting.name)
            image = self.render(setting, self.plan.patience if self.firsts else None)
            if image.interrupted:
                self.left_out[setting.name] = f"takes more than {self.plan.patience:g} s"
                continue
            self.firsts[setting] = image
            if setting.level == "reference" and not setting.method:
                self.twins[setting.samples, setting.depth, setting.cutoff] = image.pixels

    def find_truth(self) -> tuple[Truth, Pixels]:
        self.say("truth")
        depth, cutoff = self.default.depth, self.default.cutoff / FINER
        counts = halves(self.plan.truth_samples)
        images = [self.render(Setting("level", "reference", count, depth, cutoff)) for count in counts]
        one, other = (image.pixels for image in images)
        mean = (counts[0] * one + counts[1] * other) / sum(counts)
        discarded = max(float(image.stats["discarded_weight"]["mean"]) for image in images)
        return Truth(counts, depth, cutoff, difference(one, other).rmse / 2, discarded), mean

    def find_parts(self, setting: Setting, truth: Truth, pixels: Pixels) -> dict[str, Difference]:
        picture = self.firsts[setting].pixels
        twin = self.twin(setting.samples, setting.depth, setting.cutoff)
        whole = self.twin(setting.samples, truth.depth, truth.cutoff)
        pairs = ((picture, pixels), (picture, twin), (twin, whole), (whole, pixels))
        return {part: difference(*pair) for part, pair in zip(accuracy.PARTS, pairs, strict=True)}

    def take_turns(self) -> dict[Setting, list[float]]:
        """The kernels' own seconds, a round after the other."""
        times: dict[Setting, list[float]] = {setting: [] for setting in self.firsts}
        for turn in range(self.plan.repeat):
            for setting, seconds in times.items():
                self.say(f"round {turn + 1} of {self.plan.repeat}: {setting.name}")
                seconds.append(self._seconds(setting))
        return times

    def _seconds(self, setting: Setting) -> float:
        """Of one render; short ones are repeated at once, and their median counts."""
        seconds = [kernel_seconds(self.render(setting))]
        while sum(seconds) < SHORT and len(seconds) < 5:
            seconds.append(kernel_seconds(self.render(setting)))
        return statistics.median(seconds)


def kernel_seconds(image: Image) -> float:
    """By the device's events, else by the clock around the launches; without compiling."""
    seconds = image.stats["seconds"]
    return float(seconds["trace"] if seconds["kernel"] is None else seconds["kernel"])


def measure(
    scene: Scene | str | os.PathLike[str],
    plan: Plan | None = None,
    *,
    name: str = "",
    device: str | int | None = None,
    say: Say | None = None,
) -> Accuracy:
    """Renders a scene in all the ways of a plan. Takes minutes, most of them for kernels that are compiled anew.

    First renders compile and give the pictures; then every setting is rendered in turn, round after round, so that what
    else the machine does meets all alike.

    Args:
        scene: a scene or its file.
        plan: what to vary and how often; by default `Plan()`.
        name: of the scene, for the results; by default the file's.
        device: as for `Scene.render`.
        say: called with what is under way.
    """
    if not isinstance(scene, Scene):
        name, scene = name or Path(scene).stem, load(scene)
    sweep = _Sweep(scene, plan or Plan(), device, say or (lambda _text: None))
    sweep.first_renders()
    truth, pixels = sweep.find_truth()
    parts = {setting: sweep.find_parts(setting, truth, pixels) for setting in sweep.firsts}
    points = tuple(
        Point(
            setting=setting,
            default=setting == sweep.default,
            seconds=tuple(seconds),
            compile=float(sweep.firsts[setting].stats["seconds"]["compile"]),
            **parts[setting],
        )
        for setting, seconds in sweep.take_turns().items()
    )
    used = str(sweep.firsts[sweep.default].stats["device"])
    version = to_string(lib.feeler_version())
    return Accuracy(name or "scene", used, version, sweep.plan.size, truth, points, sweep.left_out)
