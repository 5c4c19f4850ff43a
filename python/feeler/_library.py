"""The shared library: where it is, its functions, and the one place that turns a failure into an exception."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import cffi

_KINDS = ("ok", "bad input", "bad usage", "io", "out of memory", "device", "interrupted")
BAD_INPUT, BAD_USAGE, IO, OUT_OF_MEMORY, DEVICE, INTERRUPTED = 1, 2, 3, 4, 5, 6

ffi: Any = cffi.FFI()


class Error(Exception):
    """What went wrong in feeler, and where.

    Attributes:
        kind: "bad input", "bad usage", "io", "out of memory", "device" or "interrupted".
        source: the file's name, or for a dict the path of the key (such as "objects[2].radius"), or "".
        path: the same as source.
        line, column: counted from 1; 0 where there is none.
        text: what is wrong, without the place.
        log: the compiler's log where a kernel failed to build, else "".
    """

    def __init__(
        self, text: str, *, code: int = BAD_USAGE, source: str = "", line: int = 0, column: int = 0, log: str = ""
    ) -> None:
        place = ":".join([source] * bool(source) + [str(number) for number in (line, column) if number])
        super().__init__("\n".join(part for part in (f"{place}: {text}" if place else text, log) if part))
        self.kind = _KINDS[code] if 0 <= code < len(_KINDS) else str(code)
        self.source = self.path = source
        self.line = line
        self.column = column
        self.text = text
        self.log = log


def _folder() -> Path:
    """The folder of libfeeler.so and feeler_cdef.h: $FEELER_LIBRARY, this package's, or the checkout's build."""
    chosen = os.environ.get("FEELER_LIBRARY")
    here = Path(__file__).resolve().parent
    folders = [Path(chosen)] if chosen else [here, here.parent.parent / "build"]
    for folder in folders:
        if (folder / "libfeeler.so").is_file() and (folder / "feeler_cdef.h").is_file():
            return folder
    places = " nor in ".join(map(str, folders))
    raise ImportError(f"libfeeler.so with feeler_cdef.h is not in {places}; run `make` in the checkout")


def _open() -> Any:
    folder = _folder()
    ffi.cdef((folder / "feeler_cdef.h").read_text(encoding="utf-8"))
    return ffi.dlopen(str(folder / "libfeeler.so"))


lib: Any = _open()


def to_string(pointer: Any) -> str:
    """The Python string of a char pointer or array; NULL is ""."""
    return ffi.string(pointer).decode("utf-8", "replace") if pointer else ""


def to_bytes(text: str | os.PathLike[str], source: str = "") -> bytes:
    """A string or path for C. A NUL inside is an error, for C would stop there."""
    encoded = os.fsencode(text)
    if b"\0" in encoded:
        raise Error(f"{text!r} contains a NUL character", code=BAD_INPUT, source=source)
    return encoded


def new_error() -> Any:
    return ffi.new("feeler_error *")


def check(result: Any, error: Any) -> Any:
    """The result of a library call, or its failure (NULL or -1) as an exception."""
    if result == (-1 if isinstance(result, int) else ffi.NULL):
        raise Error(
            to_string(error.text) or "failed without saying why",
            code=error.code,
            source=to_string(error.source),
            line=error.line,
            column=error.column,
            log=to_string(error.log),
        )
    return result


def call(function: Any, *arguments: Any) -> Any:
    """Calls a library function whose last parameter is its error; checked."""
    error = new_error()
    return check(function(*arguments, error), error)


def take_text(pointer: Any) -> str:
    """The Python string of a text that the caller must free."""
    try:
        return to_string(pointer)
    finally:
        lib.feeler_free(pointer)


def take_json(pointer: Any) -> Any:
    return json.loads(take_text(pointer))
