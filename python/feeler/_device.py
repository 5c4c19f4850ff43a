"""OpenCL devices, what may be set for a render, and the kernels' source and options."""

from __future__ import annotations

import functools
import threading
import warnings
from collections.abc import Sequence
from typing import Any

from ._library import DEVICE, Error, call, ffi, lib, take_json, take_text, to_bytes, to_string

LEVELS = ("draft", "standard", "reference")


class Device:
    """An open device; only one thread may use it at a time, so it has a lock."""

    def __init__(self, pointer: Any, parents: Any = None) -> None:
        self.pointer = ffi.gc(pointer, lib.feeler_device_close)
        self.parents = parents
        self.lock = threading.RLock()
        self.name = to_string(lib.feeler_device_name(pointer))


@functools.lru_cache(maxsize=8)
def _opened(select: str) -> Device:
    return Device(call(lib.feeler_device_open, to_bytes(select)))


def open_device(select: str | int | None, queue: Any) -> Device:
    """The chosen device, opened once and kept, or a caller's queue."""
    if queue is None:
        return _opened("" if select is None else str(select))
    if select is not None:
        raise Error("give a device or a queue, not both")
    try:
        handles = (queue.context.int_ptr, queue.device.int_ptr, queue.int_ptr)
    except AttributeError:
        raise Error(f"queue is a pyopencl.CommandQueue, not {queue!r}") from None
    return Device(call(lib.feeler_device_wrap, *handles), queue)


def devices() -> list[dict[str, Any]]:
    """Every OpenCL platform's devices: dicts with index, name, platform, type, double, default and more."""
    platforms = take_json(call(lib.feeler_devices_json))["platforms"]
    return [{**device, "platform": platform["name"]} for platform in platforms for device in platform["devices"]]


@functools.cache
def default_queue() -> Any:
    """A pyopencl queue on the device that feeler takes by default."""
    import pyopencl as cl

    index = next((device["index"] for device in devices() if device["default"]), None)
    if index is None:
        raise Error("there is no OpenCL device", code=DEVICE)
    device = [device for platform in cl.get_platforms() for device in platform.get_devices()][index]
    return cl.CommandQueue(cl.Context([device]))


def make_settings(
    *,
    size: tuple[int, int] | None = None,
    samples: int | None = None,
    jitter: float | None = None,
    depth: int | None = None,
    cutoff: float | None = None,
    level: str | None = "standard",
    region: tuple[int, int, int, int] | None = None,
    alpha: bool = False,
    work_group: tuple[int, int] | None = None,
    pixels: tuple[int, int] | None = None,
    lanes: int | None = None,
    tile: int | None = None,
    general: bool = False,
    brute_force: bool = False,
    channels: str | Sequence[str] | None = None,
) -> Any:
    """A feeler_settings; what is None stays as the library has it by default. The level None is any."""
    if level is not None and level not in LEVELS:
        raise Error(f"unknown level {level!r}: it is one of {', '.join(LEVELS)}")
    settings = ffi.new("feeler_settings *")
    lib.feeler_settings_default(settings)
    chosen = {"samples": samples, "depth": depth, "lanes": lanes, "tile": tile, "jitter": jitter, "cutoff": cutoff}
    for name, value in chosen.items():
        if value is not None:
            _set(settings, name, value)
    if size is not None:
        _set(settings, "width", _whole("size", size, 2)[0])
        _set(settings, "height", _whole("size", size, 2)[1])
    if region is not None:
        if not any(_whole("region", region, 4)):  # which means the whole picture in C
            raise Error("the region is empty")
        _set(settings, "region", _whole("region", region, 4))
    if work_group is not None:
        _set(settings, "work_group", _whole("work_group", work_group, 2))
    if pixels is not None:
        _set(settings, "pixels", _whole("pixels", pixels, 2))
    settings.level = lib.FEELER_LEVEL_ANY if level is None else LEVELS.index(level)
    settings.transparent, settings.general, settings.brute_force = bool(alpha), bool(general), bool(brute_force)
    if channels is not None:
        names = channels if isinstance(channels, str) else ",".join(_names("channels", channels))
        settings.channels = call(lib.feeler_channels_parse, to_bytes(names)) if names else 0
    return settings


def warn_of_tuned() -> None:
    """Warns of a file of work groups (see `feeler bench --save`) that cannot be used."""
    try:
        call(lib.feeler_tuned_check)
    except Error as error:
        warnings.warn(f"{error}; the work groups that are kept there are not used", RuntimeWarning, stacklevel=3)


def _names(name: str, values: Any) -> list[str]:
    try:
        names = list(values)
    except TypeError:
        names = [None]
    if not all(isinstance(one, str) for one in names):
        raise Error(f"{name} is a name or several, not {values!r}")
    return names


def _whole(name: str, values: Any, count: int) -> list[int]:
    try:
        whole = [value.__index__() for value in values]
    except (TypeError, AttributeError):
        raise Error(f"{name} is {count} whole numbers, not {values!r}") from None
    if len(whole) != count:
        raise Error(f"{name} is {count} whole numbers, not {len(whole)}")
    return whole


def _set(settings: Any, name: str, value: Any) -> None:
    # An explicit 0 or negative number would mean "the scene's own" in C; here None does, so it is a mistake.
    least = {"jitter": 0.0, "cutoff": 0.0, "region": None}.get(name, 1)
    try:
        if least is not None and not (min(value) if isinstance(value, list) else value) >= least:
            raise Error(f"{name} is at least {least:g}, not {value!r}")
        setattr(settings, name, value)
    except (TypeError, OverflowError):
        raise Error(f"{name} cannot be {value!r}") from None


def kernel_source() -> str:
    """The kernels' OpenCL C source, whole, with #line directives that name its files."""
    return to_string(lib.feeler_kernel_source())


def kernel_options(scene: Any = None, **settings: Any) -> str:
    """The kernels' build options for a scene, or without one those that compile everything."""
    pointer = ffi.NULL if scene is None else scene
    return take_text(call(lib.feeler_kernel_options, pointer, make_settings(**settings)))
