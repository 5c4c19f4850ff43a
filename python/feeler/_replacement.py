"""Files that take others' places only when the whole of them is there (host/replacement.h does it for pictures)."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path


@contextmanager
def replacement(path: str | os.PathLike[str]) -> Iterator[Path]:
    """A hidden file to write instead, of the same ending and in the same folder. It gets the name when the block ends
    without an exception, else it is removed. A link stays a link, and the mode stays the old file's.
    """
    target = Path(os.path.realpath(path))
    if target.exists() and not target.is_file():  # a pipe or a device, or a folder: opening it tells
        yield Path(path)
        return
    temporary = target.with_name(f".feeler-{os.getpid()}-{target.name}")
    try:
        yield temporary
        if target.exists():
            temporary.chmod(target.stat().st_mode & 0o777)
        temporary.replace(target)
    except OSError as error:
        error.filename = os.fspath(path)
        raise
    finally:
        with suppress(OSError):
            temporary.unlink()


def write_text(path: str | os.PathLike[str], text: str) -> None:
    with replacement(path) as temporary:
        temporary.write_text(text, encoding="utf-8")
