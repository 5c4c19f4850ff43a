"""From Python's dicts, lists and arrays to the library's nodes, the structure that a YAML file also becomes."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from numbers import Real
from typing import Any

import numpy as np

from ._library import BAD_INPUT, OUT_OF_MEMORY, Error, ffi, lib, to_bytes


def build_node(value: Any) -> Any:
    """The node of a scene's root; it frees itself."""
    if not isinstance(value, Mapping):
        raise Error(f"a scene is a mapping, not {type(value).__name__}", code=BAD_INPUT)
    try:
        return _node(value, "")
    except RecursionError:
        raise Error("the scene is nested too deeply, or contains itself", code=BAD_INPUT) from None


def _own(node: Any) -> Any:
    if node == ffi.NULL:
        raise Error("out of memory", code=OUT_OF_MEMORY)
    return ffi.gc(node, lib.feeler_node_free)


def _add(parent: Any, key: str | None, child: Any) -> None:
    encoded = ffi.NULL if key is None else to_bytes(key)
    ffi.gc(child, None)  # from here the parent owns it, even if adding fails
    if lib.feeler_node_add(parent, encoded, child):
        raise Error("out of memory", code=OUT_OF_MEMORY)


def _node(value: Any, path: str) -> Any:
    if isinstance(value, Mapping):
        return _map(value, path)
    if isinstance(value, np.ndarray):
        return _array(value, path)
    if isinstance(value, (bool, np.bool_)):
        return _own(lib.feeler_node_text(b"true" if value else b"false"))
    if isinstance(value, Real):
        return _number(value, path)
    if isinstance(value, (str, os.PathLike)):
        return _own(lib.feeler_node_text(to_bytes(value, path)))
    if isinstance(value, Sequence) and not isinstance(value, (bytes, bytearray)):
        return _list(value, path)
    raise Error(f"{type(value).__name__} cannot be part of a scene", code=BAD_INPUT, source=path)


def _number(value: Real, path: str) -> Any:
    try:
        return _own(lib.feeler_node_number(float(value)))
    except OverflowError:
        raise Error("the number is too large", code=BAD_INPUT, source=path) from None


def _map(value: Mapping[Any, Any], path: str) -> Any:
    node = _own(lib.feeler_node_map())
    for key, item in value.items():
        if not isinstance(key, str):
            raise Error(f"keys are strings, not {key!r}", code=BAD_INPUT, source=path)
        if item is not None:  # None: as if the key were not there
            _add(node, key, _node(item, f"{path}.{key}" if path else key))
    return node


def _list(value: Sequence[Any], path: str) -> Any:
    node = _own(lib.feeler_node_list())
    for index, item in enumerate(value):
        _add(node, None, _node(item, f"{path}[{index}]"))
    return node


def _array(value: np.ndarray[Any, Any], path: str) -> Any:
    if value.ndim != 2 or value.dtype.kind not in "iuf" or not value.size:
        return _node(value.tolist(), path)
    values = np.ascontiguousarray(value, dtype=np.float64)
    return _own(lib.feeler_node_array(ffi.cast("const double *", values.ctypes.data), *values.shape))
