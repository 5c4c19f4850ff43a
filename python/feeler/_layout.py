"""How values of the kernels' types lie in numpy arrays: a value is a list of leaves, each a vector or scalar type."""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from math import prod
from typing import Any

import numpy as np
import numpy.typing as npt

from ._library import Error
from ._prototypes import Prototypes, Variable

Array = npt.NDArray[Any]


@dataclass(frozen=True)
class Kind:
    """A type without members: the C type that stores it, its number's type, and how many of them it has."""

    stored: str
    number: str
    width: int = 1
    lanes: bool = False  # one per lane instead of one per work-item


KINDS = {
    "reals": Kind("reals", "real", lanes=True),
    "ints": Kind("ints", "integer", lanes=True),
    "uints": Kind("uints", "uint", lanes=True),
    "integer": Kind("integer", "integer"),
    "bool": Kind("int", "int"),
    "long": Kind("long", "long"),
    "ulong": Kind("ulong", "ulong"),
    "size_t": Kind("ulong", "ulong"),
    **{f"{name}{width or ''}": Kind(f"{name}{width or ''}", name, width or 1)
       for name in ("real", "int", "uint", "float", "double") for width in (0, 2, 4, 8, 16)},
}  # fmt: skip


@dataclass(frozen=True)
class Leaf:
    """A part of a value: `path` is what C writes after the value's name, such as ".normal.x"."""

    path: str
    kind: Kind


class Layout:
    """The types of one build of the kernels: their structs, numbers' sizes and lanes."""

    def __init__(self, prototypes: Prototypes, lanes: int, double: bool) -> None:
        self.structs = prototypes.structs
        self.lanes = lanes
        self.dtypes: dict[str, npt.DTypeLike] = {
            "real": np.float64 if double else np.float32,
            "integer": np.int64 if double else np.int32,
            "float": np.float32, "double": np.float64,
            "int": np.int32, "uint": np.uint32, "long": np.int64, "ulong": np.uint64,
        }  # fmt: skip

    def leaves(self, type_: str, shape: tuple[int, ...] = (), path: str = "") -> Iterator[Leaf]:
        """The leaves of a value in the order of their declaration."""
        if shape:
            for index in range(shape[0]):
                yield from self.leaves(type_, shape[1:], f"{path}[{index}]")
        elif type_ in KINDS:
            yield Leaf(path, KINDS[type_])
        else:
            for member in self.members(type_):
                if not member.space:
                    yield from self.leaves(member.type, member.shape, f"{path}.{member.name}")

    def tables(self, type_: str, path: str = "") -> Iterator[tuple[str, Variable]]:
        """The pointers among a struct's own members, each with its path."""
        if type_ not in KINDS:
            yield from ((f"{path}.{member.name}", member) for member in self.members(type_) if member.space)

    def members(self, type_: str) -> tuple[Variable, ...]:
        if type_ not in self.structs:
            raise Error(f"probe does not know the type {type_!r}")
        return self.structs[type_]

    def numbers(self, type_: str, shape: tuple[int, ...] = ()) -> tuple[npt.DTypeLike, int]:
        """The one number type of a value and how many numbers it is; an error where types mix."""
        kinds = [leaf.kind for leaf in self.leaves(type_, shape)]
        if len({kind.number for kind in kinds}) != 1:
            raise Error(f"{type_!r} mixes types of numbers: give a dict, a tuple of its members or a structured array")
        return self.dtypes[kinds[0].number], sum(kind.width for kind in kinds)

    # ---- from numpy: one array per leaf, of the shape (…) or, for a vector type, (…, width)

    def split(self, type_: str, value: Any, name: str, shape: tuple[int, ...] = ()) -> list[Array]:
        if value is None:
            return [np.zeros(leaf.kind.width if leaf.kind.width > 1 else ()) for leaf in self.leaves(type_, shape)]
        if shape and not isinstance(value, tuple):
            return self._split_numbers(type_, value, name, shape)
        if shape:
            _same_length(value, shape[0], name)
            return [part for i, item in enumerate(value) for part in self.split(type_, item, f"{name}[{i}]", shape[1:])]
        if type_ in KINDS:
            return [self._numbers_of(KINDS[type_], value, name)]
        fields = value.dtype.names if isinstance(value, np.ndarray) else None
        if isinstance(value, (Mapping, tuple)) or fields:
            return self._split_members(type_, value, name)
        return self._split_numbers(type_, value, name, ())

    def _split_members(self, type_: str, value: Any, name: str) -> list[Array]:
        members = self.members(type_)
        if isinstance(value, tuple):
            _same_length(value, len(members), name)
            value = dict(zip([member.name for member in members], value, strict=True))
        given = set(value if isinstance(value, Mapping) else value.dtype.names)
        wrong = given.symmetric_difference(member.name for member in members)
        wrong -= {member.name for member in members if member.space}  # a table may be left out
        if wrong:
            raise Error(f"{name}: members {', '.join(sorted(wrong))} are unknown or missing in {type_!r}")
        parts = (self.split(m.type, value[m.name], f"{name}.{m.name}", m.shape) for m in members if not m.space)
        return [leaf for part in parts for leaf in part]

    def _split_numbers(self, type_: str, value: Any, name: str, shape: tuple[int, ...]) -> list[Array]:
        dtype, width = self.numbers(type_, shape)
        numbers = _as_array(value, dtype, name)
        one = width // prod(shape)
        whole = (*shape, one) if one > 1 else shape
        if shape and numbers.shape[-len(whole) :] == whole:
            numbers = numbers.reshape((*numbers.shape[: -len(whole)], width))
        if numbers.ndim == 0 or numbers.shape[-1] != width:
            raise Error(f"{name}: the shape is {numbers.shape}, not (…, {width}) as {type_!r} asks")
        ends = np.cumsum([leaf.kind.width for leaf in self.leaves(type_, shape)])
        parts = np.split(numbers, ends[:-1], axis=-1)
        return [part if part.shape[-1] > 1 else part[..., 0] for part in parts]

    def _numbers_of(self, kind: Kind, value: Any, name: str) -> Array:
        numbers = _as_array(value, None, name)
        if numbers.dtype == bool and kind.lanes and self.lanes > 1:
            numbers = -numbers.astype(np.int8)  # a mask's true
        numbers = _as_array(numbers, self.dtypes[kind.number], name)
        if kind.width > 1 and (numbers.ndim == 0 or numbers.shape[-1] != kind.width):
            raise Error(f"{name}: the shape is {numbers.shape}, not (…, {kind.width})")
        return numbers

    # ---- to numpy

    def join(self, type_: str, parts: Iterator[Array], shape: tuple[int, ...] = ()) -> Any:
        """The value whose leaves come from `parts`: an array, or a named tuple of them for a struct."""
        if shape:
            items = [self.join(type_, parts, shape[1:]) for _ in range(shape[0])]
            plain = type_ in KINDS and KINDS[type_].width == 1
            return np.stack(items, axis=-len(shape)) if plain else tuple(items)
        if type_ in KINDS:
            return next(parts)
        members = [member for member in self.members(type_) if not member.space]
        values = [self.join(member.type, parts, member.shape) for member in members]
        if all(KINDS.get(member.type) == KINDS["reals"] and not member.shape for member in members):
            return np.stack(values, axis=-1)
        return namedtuple(type_, [member.name for member in members])(*values)


def _same_length(value: tuple[Any, ...], length: int, name: str) -> None:
    if len(value) != length:
        raise Error(f"{name}: {len(value)} items given, {length} needed")


def _as_array(value: Any, dtype: npt.DTypeLike | None, name: str) -> Array:
    try:
        array = np.asarray(value, dtype)
    except (TypeError, ValueError, OverflowError) as error:
        raise Error(f"{name}: {error}") from None
    if array.dtype.kind not in "biuf":
        raise Error(f"{name}: numbers are needed, not {array.dtype}")
    return array
