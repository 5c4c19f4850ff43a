"""Reads OpenEXR files as feeler writes them (scan lines, numbers of 32 bits, ZIP) and writes plain ones, both without OpenEXR."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

LINES_PER_BLOCK = {0: 1, 2: 1, 3: 16}  # by compression: none, ZIPS, ZIP


def _read_text(data: bytes, at: int) -> tuple[str, int]:
    end = data.index(b"\0", at)
    return data[at:end].decode(), end + 1


def _read_header(data: bytes) -> tuple[dict[str, Any], int]:
    assert struct.unpack_from("<II", data) == (20000630, 2) or struct.unpack_from("<II", data) == (20000630, 0x402)
    header: dict[str, Any] = {}
    at = 8
    while data[at]:
        name, at = _read_text(data, at)
        kind, at = _read_text(data, at)
        (size,) = struct.unpack_from("<i", data, at)
        value = data[at + 4 : at + 4 + size]
        at += 4 + size
        header[name] = {
            "box2i": lambda v=value: struct.unpack("<4i", v),
            "string": lambda v=value: v.decode(),
            "compression": lambda v=value: v[0],
        }.get(kind, lambda v=value: v)()
    return header, at + 1


TYPES = {0: "<u4", 2: "<f4"}


def _channels(value: bytes) -> dict[str, str]:
    types, at = {}, 0
    while value[at]:
        name, at = _read_text(value, at)
        types[name] = TYPES[struct.unpack_from("<i", value, at)[0]]
        at += 16
    return types


def _unpack(block: bytes, size: int) -> bytes:
    """Undoes ZIP: the bytes' differences, then their halves' interleaving. What does not shrink is kept as it is."""
    if len(block) == size:
        return block
    differences = np.frombuffer(zlib.decompress(block), np.uint8).astype(np.uint32)
    differences[1:] += 128
    halves = np.cumsum(differences).astype(np.uint8)
    whole = np.empty_like(halves)
    whole[0::2], whole[1::2] = halves[: (size + 1) // 2], halves[(size + 1) // 2 :]
    return whole.tobytes()


def read_layers(path: Path) -> tuple[dict[str, NDArray[Any]], dict[str, Any]]:
    """The planes of the data window by their channels' names, (height, width), and the attributes of the header."""
    data = path.read_bytes()
    header, at = _read_header(data)
    types = _channels(header["channels"])
    names = list(types)
    x0, y0, x1, y1 = header["dataWindow"]
    width, height = x1 - x0 + 1, y1 - y0 + 1
    lines = LINES_PER_BLOCK[header["compression"]]
    planes = np.empty((height, len(names), width), np.float32)
    at += 8 * -(-height // lines)  # the table of offsets; the blocks follow each other anyway
    for _ in range(0, height, lines):
        y, size = struct.unpack_from("<ii", data, at)
        count = min(lines, height - (y - y0))
        raw = _unpack(data[at + 8 : at + 8 + size], count * len(names) * width * 4)
        planes[y - y0 : y - y0 + count] = np.frombuffer(raw, "<f4").reshape(count, len(names), width)
        at += 8 + size
    return {name: planes[:, i].copy().view(type_) for i, (name, type_) in enumerate(types.items())}, header


def read_exr(path: Path) -> tuple[NDArray[np.float32], dict[str, Any]]:
    """The picture, (height, width, RGB or RGBA), and the attributes of the header."""
    layers, header = read_layers(path)
    return np.stack([layers[name] for name in "RGBA" if name in layers], -1), header


def write_layers(path: Path, layers: dict[str, Any]) -> None:
    """Writes planes of one size, (height, width), as floats under their channels' names, not compressed."""
    names = sorted(layers)  # as the format demands
    planes = np.stack([np.asarray(layers[name], "<f4") for name in names], 1)
    height, _, width = planes.shape
    window = struct.pack("<4i", 0, 0, width - 1, height - 1)
    channel = struct.pack("<iB3xii", 2, 0, 1, 1)
    attributes = [
        ("channels", "chlist", b"".join(name.encode() + b"\0" + channel for name in names) + b"\0"),
        ("compression", "compression", b"\0"),
        ("dataWindow", "box2i", window),
        ("displayWindow", "box2i", window),
        ("lineOrder", "lineOrder", b"\0"),
        ("pixelAspectRatio", "float", struct.pack("<f", 1)),
        ("screenWindowCenter", "v2f", struct.pack("<2f", 0, 0)),
        ("screenWindowWidth", "float", struct.pack("<f", 1)),
    ]
    header = struct.pack("<II", 20000630, 2)
    for name, kind, value in attributes:
        header += f"{name}\0{kind}\0".encode() + struct.pack("<i", len(value)) + value
    header += b"\0"
    blocks = [struct.pack("<ii", y, line.nbytes) + line.tobytes() for y, line in enumerate(planes)]
    first = len(header) + 8 * height
    table = struct.pack(f"<{height}Q", *(first + y * len(blocks[0]) for y in range(height)))
    path.write_bytes(header + table + b"".join(blocks))
