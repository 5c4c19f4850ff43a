"""Scenes and rendering them."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ._device import kernel_options, make_settings, open_device, warn_of_tuned
from ._library import INTERRUPTED, Error, call, check, ffi, lib, new_error, take_json, take_text, to_bytes, to_string
from ._nodes import build_node
from .compare import Difference, compare
from .image import Image
from .pixel import Pixel

Progress = Callable[[float], Any]


def load(path: str | os.PathLike[str]) -> Scene:
    """Reads a scene: feeler's YAML (.yaml, .yml), NFF (.nff) or a mesh file (.obj, .ply, .stl, .gltf, …).

    A mesh alone gets a camera that frames it, a light and a material. Relative names in a scene are relative to it.
    """
    return Scene._of(call(lib.feeler_scene_load, to_bytes(path)), os.fspath(path))


class Scene:
    """A checked scene. It never changes; render it as often and in as many ways as you like."""

    def __init__(self, description: Mapping[str, Any], directory: str | os.PathLike[str] | None = None) -> None:
        """Makes a scene from the structure of a YAML scene file.

        Args:
            description: a dict with the keys of docs/scene-format.md, of dicts, lists, tuples, numbers, bools and
                strings. numpy arrays may stand for vectors (3,), matrices (4, 4) and a mesh's lists of vertices (n, 3),
                normals (n, 3) and triangles (n, 3). A key whose value is None counts as absent.
            directory: what relative file names are relative to; by default the working directory.
        """
        node = build_node(description)
        self._take(
            call(lib.feeler_scene_from_node, node, ffi.NULL if directory is None else to_bytes(directory)), "of a dict"
        )

    @classmethod
    def _of(cls, pointer: Any, origin: str) -> Scene:
        scene = cls.__new__(cls)
        scene._take(pointer, origin)
        return scene

    def _take(self, pointer: Any, origin: str) -> None:
        self._pointer = ffi.gc(pointer, lib.feeler_scene_free)
        self._origin = origin
        self._lock = threading.RLock()

    def __repr__(self) -> str:
        return f"<feeler.Scene {self._origin}>"

    @property
    def warnings(self) -> list[str]:
        """What was odd but no error, such as triangles without area."""
        found: list[str] = []
        while warning := lib.feeler_scene_warning(self._pointer, len(found)):
            found.append(to_string(warning))
        return found

    def info(self, **settings: Any) -> dict[str, Any]:
        """What the scene contains, the features it needs, the kernel's options and its memory, as `feeler info --json`.

        Takes the settings of `render` that change the kernel or the picture.
        """
        with self._lock:
            info: dict[str, Any] = take_json(call(lib.feeler_scene_info_json, self._pointer, make_settings(**settings)))
            return info

    def kernel_options(self, **settings: Any) -> str:
        """The build options of the kernels for this scene and settings of `render`."""
        with self._lock:
            return kernel_options(self._pointer, **settings)

    def render(
        self,
        size: tuple[int, int] | None = None,
        samples: int | None = None,
        jitter: float | None = None,
        depth: int | None = None,
        cutoff: float | None = None,
        level: str | None = None,
        region: tuple[int, int, int, int] | None = None,
        alpha: bool = False,
        tolerance: float | None = None,
        queue: Any = None,
        device: str | int | None = None,
        work_group: tuple[int, int] | None = None,
        pixels: tuple[int, int] | None = None,
        lanes: int | None = None,
        tile: int | None = None,
        general: bool = False,
        brute_force: bool = False,
        channels: str | Sequence[str] | None = None,
        progress: bool | Progress | None = None,
    ) -> Image:
        """Renders the scene. What is None is the scene's own, or chosen.

        Other threads run meanwhile. A KeyboardInterrupt ends the render within a second; the exception's attribute
        `image` is what was done until then, None while a tolerance's settings were sought.

        Args:
            size: width and height of the whole picture, pixels.
            samples: per pixel.
            jitter: 0 (samples in their cells' centres) to 1 (anywhere in their cells).
            depth: how many rays may follow each other, the eye ray being the first.
            cutoff: rays whose weight is below it are not sent; 0 to 1.
            level: "draft", "standard" (float32, robust; the default) or "reference" (float64).
            region: x0, y0, x1, y1, half open, pixels from the top left: render only these.
            alpha: True leaves the background out of the colour; the alpha is then the coverage.
            tolerance: find the cheapest level, samples and cutoff, of those that are not given, whose error is below
                it: the 99.9th percentile of `feeler.compare` against level "reference" with many samples.
                `stats["tolerance"]` says what was chosen, why, and the error; where its "reached" is false the image
                is the best that was found.
            queue: a pyopencl.CommandQueue to render on.
            device: a number in `feeler.devices()` or part of a device's name, instead of a queue.
            work_group: x, y; by default the one that `feeler bench --save` keeps for this device and kernel, if any.
                Like pixels, lanes and tile it never changes the picture.
            pixels: x, y: of a work-item, 1 x 1 by default; powers of two, together at most as many as lanes.
            lanes: samples that are traced side by side: 1, 2, 4, 8 or 16.
            tile: pixels per launch.
            general: compile everything, not only what the scene needs (for tests).
            brute_force: try every object for every ray (for tests).
            channels: names of what else to find out, such as ["depth", "margin"], or "all": see `Image.channels`.
            progress: True shows a bar; a function is called several times a second with the share done, 0 to 1, and
                stops the render by returning something true: the image so far is then returned, `interrupted`.
        """
        if level is None and tolerance is None:
            level = "standard"
        settings = make_settings(
            size=size, samples=samples, jitter=jitter, depth=depth, cutoff=cutoff, level=level, region=region,
            alpha=alpha, work_group=work_group, pixels=pixels, lanes=lanes, tile=tile, general=general,
            brute_force=brute_force, channels=channels,
        )  # fmt: skip
        if work_group is None:
            warn_of_tuned()
        opened = open_device(device, queue)
        with _Reporter(progress) as reporter, self._lock, opened.lock:
            error = new_error()
            rest = opened.pointer, reporter.callback, ffi.NULL, error
            if tolerance is None:
                pointer = lib.feeler_render(self._pointer, settings, *rest)
            else:
                pointer = lib.feeler_render_within(self._pointer, settings, _number("tolerance", tolerance), *rest)
            reporter.raise_caught_without(pointer)
            image = Image(check(pointer, error), interrupted=error.code == INTERRUPTED, alpha=alpha)
        reporter.raise_caught(image)
        return image

    def pixel(
        self,
        x: int,
        y: int,
        sample: int | None = None,
        size: tuple[int, int] | None = None,
        samples: int | None = None,
        jitter: float | None = None,
        depth: int | None = None,
        cutoff: float | None = None,
        level: str = "standard",
        alpha: bool = False,
        queue: Any = None,
        device: str | int | None = None,
        general: bool = False,
    ) -> Pixel:
        """All that the rays of one pixel do: what each meets, what lights it, what is sent on. "Why is it black?"

        The kernels that render a picture take notes, so this is what led to the picture's pixel, to the bit.

        Args:
            x, y: the pixel, counted from 0 at the top left.
            sample: only this one, from 0; by default all.
            size, samples, jitter, depth, cutoff, level, alpha, queue, device, general: as for `render`.
        """
        settings = make_settings(
            size=size, samples=samples, jitter=jitter, depth=depth, cutoff=cutoff, level=level, alpha=alpha,
            general=general,
        )  # fmt: skip
        at = [_whole("x", x), _whole("y", y), -1 if sample is None else _whole("sample", sample)]
        opened = open_device(device, queue)
        with self._lock, opened.lock:
            return Pixel(take_text(call(lib.feeler_pixel_json, self._pointer, settings, opened.pointer, *at)))

    def verify(self, **settings: Any) -> Verification:
        """Renders twice, as it is asked and at level "reference" with the same samples, and compares.

        Takes the settings of `render` but tolerance; level is "draft" or "standard". The figures are those of
        precision; what depth and cutoff left away is bounded apart from them.
        """
        device, queue, progress = (settings.get(name) for name in ("device", "queue", "progress"))
        if settings.get("tolerance") is not None:
            raise Error("verify takes no tolerance, which measures the error already")
        image = self.render(**settings)
        if image.interrupted:
            raise Error("the render was interrupted: there is nothing to verify", code=INTERRUPTED)
        opened = open_device(device, queue)
        with _Reporter(progress) as reporter, self._lock, opened.lock:
            error = new_error()
            pointer = lib.feeler_verify(
                self._pointer, image._pointer, opened.pointer, reporter.callback, ffi.NULL, error
            )
            reporter.raise_caught_without(pointer)
            reference = Image(check(pointer, error), interrupted=False, alpha=image._alpha)
        bound = image.stats["verification"]["truncation_bound"]
        return Verification(
            image, reference, compare(image, reference), float("inf") if bound == "unbounded" else float(bound)
        )


def _whole(name: str, value: int) -> int:
    if not hasattr(value, "__index__") or not 0 <= value.__index__() < 2**31:
        raise Error(f"{name} is a whole number from 0 on, not {value!r}")
    return value.__index__()


def _number(name: str, value: Any) -> float:
    try:
        return float(value)
    except (TypeError, ValueError):
        raise Error(f"{name} is a number, not {value!r}") from None


@dataclass(frozen=True)
class Verification:
    """A picture beside its own at level "reference".

    Attributes:
        image: as it was asked; its `stats["verification"]` has the figures.
        reference: with the same samples, depth and cutoff, in double precision.
        precision: how far they are apart.
        truncation_bound: greatest error of a channel by rays that depth or cutoff did not let go; maybe infinite.
    """

    image: Image
    reference: Image
    precision: Difference
    truncation_bound: float


class _Reporter:
    """The library's progress callback: tells the caller's function or bar, and keeps what they raise for later."""

    def __init__(self, progress: bool | Progress | None) -> None:
        self.function = progress if callable(progress) else None
        self.bar = _make_bar() if progress is True else None
        self.caught: BaseException | None = None
        self.callback = ffi.callback("int(void *, double)", self._report, error=1, onerror=self._catch)

    def _report(self, _user: Any, fraction: float) -> int:
        if self.bar is not None:
            self.bar.update(fraction - self.bar.n)
        return int(bool(self.function(fraction))) if self.function else 0

    def _catch(self, _kind: Any, exception: BaseException, _traceback: Any) -> None:
        self.caught = self.caught or exception

    def raise_caught_without(self, pointer: Any) -> None:
        """Where what was caught left no image."""
        if not pointer:
            self.raise_caught(None)

    def raise_caught(self, image: Image | None) -> None:
        if self.caught is not None:
            self.caught.image = image  # type: ignore[attr-defined]
            raise self.caught

    def __enter__(self) -> _Reporter:
        return self

    def __exit__(self, *_: object) -> None:
        if self.bar is not None:
            self.bar.close()


def _make_bar() -> Any:
    from tqdm.auto import tqdm

    return tqdm(total=1.0, desc="render", bar_format="{desc} {percentage:3.0f}% |{bar}| {elapsed} < {remaining}")
