"""Runs single device functions of the kernels over numpy arrays, for tests and for looking closely."""

from __future__ import annotations

import functools
import warnings
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from ._device import default_queue, kernel_options, kernel_source
from ._layout import Array, Layout, Leaf
from ._library import DEVICE, Error
from ._prototypes import Function, Prototypes, Variable, read_prototypes


def probe(
    name: str,
    *arguments: Any,
    level: str = "standard",
    lanes: int = 1,
    options: str | None = None,
    queue: Any = None,
) -> Any:
    """Runs one device function of the kernels for every element of its arguments.

    Each argument has a leading shape, and they broadcast against each other as numpy's do; the function runs once per
    element. After the leading shape come the type's own numbers:

        real, int, uint, bool, reals, ints, …   (…)
        real4, uint4                            (…, 4)
        vectors                                 (…, 3)
        a struct of one type of numbers         (…, its numbers), such as (…, 12) for a sphere; or as the next
        any struct                              a dict or tuple of its members, or a structured array
        T x[N] in a struct (x[N][M] likewise)   (…, N) or (…, N, numbers of T), or a tuple of N values
        private T *x                            as T; what the function leaves there is returned
        global T *x, constant T *x              one array for all, not broadcast: (n, numbers of T); as a struct's
                                                member (give a dict then) it may be left out

    None stands for zeros. Numbers are rounded to the level's type. A struct comes back as a named tuple of arrays.

    Args:
        name: of the function, such as "intersect_sphere".
        arguments: one for each parameter.
        level: "draft" and "standard" compute in float32, "reference" in float64.
        lanes: width of `reals` and `ints`. Where every argument that has no lanes is the same for all elements, a
            work-item takes `lanes` consecutive elements; else, and with the option "-DRAYS=1", each element has a
            work-item, in all of its lanes. A result without lanes has an element per work-item.
        options: more build options, such as "-DSTACK=3".
        queue: a pyopencl.CommandQueue; by default one on feeler's default device.

    Returns:
        The function's value and then what its private pointers (not const, and global ones likewise) were left with;
        a tuple when there are several.
    """
    built = kernel_options(level=level, lanes=lanes, samples=lanes)
    if options:
        built = f"{built} {options}"
    prototypes = _prototypes(built)
    function = prototypes.function(name)
    if len(arguments) != len(function.parameters):
        names = ", ".join(parameter.name for parameter in function.parameters)
        raise Error(f"{name} takes {len(function.parameters)} arguments ({names}), not {len(arguments)}")
    call = _Call(function, Layout(prototypes, lanes, level == "reference"), prototypes.macros["RAYS"] == lanes)
    return call.run(arguments, queue or default_queue(), built)


@functools.lru_cache(maxsize=16)
def _prototypes(options: str) -> Prototypes:
    return read_prototypes(kernel_source(), options)


class _Slot(NamedTuple):
    """Where a leaf is: in the buffer of its stored type, at this place."""

    target: str  # what C writes for it
    leaf: Leaf
    place: int


class _Table(NamedTuple):
    """A whole array behind a pointer: a parameter, or a member (then C assigns it to `target`) of one."""

    target: str
    pointer: Variable
    parameter: Variable


def _member(value: Any, name: str) -> Any:
    return value.get(name) if isinstance(value, Mapping) else getattr(value, name, None)


class _Call:
    """A function, how its arguments are laid out, and the kernel that calls it."""

    def __init__(self, function: Function, layout: Layout, packs: bool) -> None:
        self.function = function
        self.layout = layout
        self.packs = packs  # whether lanes may hold different elements
        self.values = [p for p in function.parameters if p.space in ("", "private")]
        self.tables = [_Table("", p, p) for p in function.parameters if p.space not in ("", "private")]
        self.tables += [
            _Table(f"v_{p.name}{path}", member, p) for p in self.values for path, member in layout.tables(p.type)
        ]
        for table in self.tables:
            if table.pointer.space == "local":
                raise Error(f"{function.name}: probe cannot give the local array {table.pointer.name!r}")
        self.inputs = self._slots([(f"v_{p.name}", p) for p in self.values])
        returned = [("result", Variable("result", function.returns))] if function.returns != "void" else []
        self.outputs = returned + [(f"v_{p.name}", p) for p in self.values if p.space and not p.constant]
        self.results = self._slots(self.outputs)

    def _slots(self, variables: list[tuple[str, Variable]]) -> list[_Slot]:
        used: dict[str, int] = {}
        slots = []
        for target, variable in variables:
            for leaf in self.layout.leaves(variable.type, variable.shape):
                place = used.setdefault(leaf.kind.stored, 0)
                used[leaf.kind.stored] += 1
                slots.append(_Slot(target + leaf.path, leaf, place))
        return slots

    def source(self) -> str:
        """The kernel: reads each leaf, calls the function, writes each leaf of what came of it."""
        pointers = [f"global const {stored} *in_{stored}" for stored in _stored(self.inputs)]
        pointers += [f"global {stored} *out_{stored}" for stored in _stored(self.results)]
        pointers += [
            f"{table.pointer.space} {'const ' * table.pointer.constant}{table.pointer.type} *{self._argument(table)}"
            for table in self.tables
        ]
        result = "" if self.function.returns == "void" else f"{self.function.returns} result = "
        passed = ", ".join(f"{'&' * (p.space == 'private')}v_{p.name}" for p in self.function.parameters)
        lines = [f"{p.type} v_{p.name}{''.join(f'[{n}]' for n in p.shape)};" for p in self.values]
        lines += [f"{s.target} = in_{s.leaf.kind.stored}[{s.place} * n + i];" for s in self.inputs]
        lines += [f"{table.target} = {self._argument(table)};" for table in self.tables if table.target]
        lines += [f"{result}{self.function.name}({passed});"]
        lines += [f"out_{s.leaf.kind.stored}[{s.place} * n + i] = {s.target};" for s in self.results]
        body = "\n".join(
            f"    {line}" for line in ["const size_t n = get_global_size(0), i = get_global_id(0);", *lines]
        )
        widths = f"typedef char probe_width[sizeof(reals) == {self.layout.lanes} * sizeof(real) ? 1 : -1];"
        return f'\n#line 1 "probe"\n{widths}\nkernel void probe_kernel({", ".join(pointers)})\n{{\n{body}\n}}\n'

    @staticmethod
    def _argument(table: _Table) -> str:
        return f"t_{table.parameter.name}_{table.pointer.name}" if table.target else f"v_{table.parameter.name}"

    def run(self, arguments: tuple[Any, ...], queue: Any, options: str) -> Any:
        given = dict(zip(self.function.parameters, arguments, strict=True))
        parts = [
            part
            for p in self.values
            for part in self.layout.split(p.type, given[p], f"{self.function.name}: {p.name}", p.shape)
        ]
        grid = _Grid(self.inputs, parts, self.layout.lanes, self.packs, self.function.name)
        tables = [self._table(table, given[table.parameter]) for table in self.tables]
        filled = {
            stored: np.concatenate([
                grid.spread(slot.leaf, part).ravel().astype(self.layout.dtypes[slot.leaf.kind.number])
                for slot, part in zip(self.inputs, parts, strict=True) if slot.leaf.kind.stored == stored
            ])
            for stored in _stored(self.inputs)
        }  # fmt: skip
        empty = {stored: self._empty(stored, grid.items) for stored in _stored(self.results)}
        kernel = _build(queue.context, options, self.source())
        _launch(queue, kernel, grid.items, [*filled.values()], [*empty.values(), *tables])
        found = iter([grid.gather(slot.leaf, empty[slot.leaf.kind.stored], slot.place) for slot in self.results])
        results = [self.layout.join(variable.type, found, variable.shape) for _, variable in self.outputs]
        writable = [
            not table.target and table.pointer.space == "global" and not table.pointer.constant for table in self.tables
        ]
        results += [array for array, left in zip(tables, writable, strict=True) if left]
        return results[0] if len(results) == 1 else tuple(results)

    def _empty(self, stored: str, items: int) -> Array:
        kinds = [slot.leaf.kind for slot in self.results if slot.leaf.kind.stored == stored]
        width = self.layout.lanes if kinds[0].lanes else kinds[0].width
        return np.zeros((len(kinds), items, width), self.layout.dtypes[kinds[0].number])

    def _table(self, table: _Table, value: Any) -> Array:
        """The array for a pointer; for a struct's member that was left out an empty one."""
        dtype, width = self.layout.numbers(table.pointer.type)
        if table.target:
            value = _member(value, table.pointer.name)
        array = np.array(np.zeros((0, width)) if value is None else value, dtype, order="C")
        if width > 1 and (array.ndim != 2 or array.shape[1] != width):
            name = f"{self.function.name}: {table.parameter.name}: {table.pointer.name}"
            raise Error(f"{name}: the shape is {array.shape}, not (n, {width})")
        return array


def _stored(slots: list[_Slot]) -> list[str]:
    return list(dict.fromkeys(slot.leaf.kind.stored for slot in slots))


class _Grid:
    """Which elements each work-item takes: `lanes` consecutive ones, or one that fills all of its lanes."""

    def __init__(self, slots: list[_Slot], parts: list[Array], lanes: int, packs: bool, name: str) -> None:
        leading = [_leading(slot.leaf, part) for slot, part in zip(slots, parts, strict=True)]
        try:
            self.shape = np.broadcast_shapes(*leading)
        except ValueError:
            raise Error(f"{name}: the shapes {', '.join(map(str, leading))} do not broadcast") from None
        varied = any(np.prod(shape) > 1 for slot, shape in zip(slots, leading, strict=True) if not slot.leaf.kind.lanes)
        self.lanes = lanes
        self.packed = packs and not varied
        self.size = int(np.prod(self.shape))
        if not self.size:
            raise Error(f"{name}: the arguments have no elements")
        self.items = -(-self.size // lanes) if self.packed else self.size

    def spread(self, leaf: Leaf, part: Array) -> Array:
        """The leaf's numbers in the order of the work-items."""
        width = part.shape[-1:] if leaf.kind.width > 1 else ()
        flat = np.broadcast_to(part, self.shape + width).reshape((self.size, *width))
        if not leaf.kind.lanes:
            return flat[: self.items]
        if not self.packed:
            return np.repeat(flat, self.lanes, axis=0)
        last = np.minimum(np.arange(self.items * self.lanes), self.size - 1)
        return np.asarray(flat[last])

    def gather(self, leaf: Leaf, buffer: Array, index: int) -> Array:
        """A leaf of the results in the arguments' leading shape."""
        values = np.asarray(buffer[index])
        if leaf.kind.lanes:
            flat = values.reshape(-1)[: self.size] if self.packed else values[:, 0]
            return np.asarray(flat).reshape(self.shape)
        shape = self.shape if self.items == self.size else (self.items,)
        return values.reshape(shape + ((leaf.kind.width,) if leaf.kind.width > 1 else ()))


def _leading(leaf: Leaf, part: Array) -> tuple[int, ...]:
    return part.shape[:-1] if leaf.kind.width > 1 else part.shape


def _launch(queue: Any, program: Any, items: int, inputs: list[Array], outputs: list[Array]) -> None:
    """Runs the kernel; `outputs` are read and written in place."""
    import pyopencl as cl

    flags = cl.mem_flags.READ_WRITE | cl.mem_flags.COPY_HOST_PTR
    arrays = [array if array.nbytes else np.zeros(16, array.dtype) for array in [*inputs, *outputs]]
    try:
        kernel = cl.Kernel(program, "probe_kernel")
        buffers = [cl.Buffer(queue.context, flags, hostbuf=array) for array in arrays]
        ran = kernel(queue, (items,), (1,), *buffers)  # a driver may choose a group too large for its stack
        for array, buffer in zip(outputs, buffers[len(inputs) :], strict=True):
            if array.nbytes:
                cl.enqueue_copy(queue, array, buffer, wait_for=[ran])
        queue.finish()
    except cl.Error as error:
        raise Error(f"OpenCL failed: {error}", code=DEVICE) from None


@functools.lru_cache(maxsize=512)
def _build(context: Any, options: str, source: str) -> Any:
    import pyopencl as cl

    program = cl.Program(context, kernel_source() + source)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", cl.CompilerWarning)
            return program.build(options, cache_dir=False)
    except cl.RuntimeError as error:
        raise Error("the kernel of a probe failed to build", code=DEVICE, log=str(error)) from None
