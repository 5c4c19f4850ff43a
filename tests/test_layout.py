"""The structs that host and device share lie alike in C, on the device in both precisions, and in numpy."""

from __future__ import annotations

import functools
import json
import os
import re
import shlex
import subprocess
from typing import Any

import numpy as np
import pytest
from places import ROOT

import feeler

TYPES = feeler.kernel_source().split('#line 1 "features.cl"')[0]
STRUCT = re.compile(r"typedef struct \{([^}]*)\} (\w+);")


def members() -> dict[str, dict[str, str]]:
    """The members' types by struct and name, as types.h has them for the device; what C alone sees is left out. The type
    of an array ends with its lengths.
    """
    text = re.sub(r"/\*.*?\*/", "", TYPES, flags=re.DOTALL)
    text = text[text.index("#include <stdint.h>") :].split("#endif", 1)[1]
    found: dict[str, dict[str, str]] = {}
    for body, name in STRUCT.findall(text):
        found[name] = {}
        for declaration in filter(None, map(str.strip, body.split(";"))):
            kind, names = declaration.split(None, 1)
            for member in names.split(","):
                lengths = re.findall(r"\[\w+\]", member)
                found[name][member.partition("[")[0].strip()] = kind + "".join(lengths)
    assert {"bounds", "cone", "material", "view", "launch"} <= set(found)
    assert len(found) == text.count("typedef")
    return found


STRUCTS = members()
Layout = dict[str, list[int]]  # by struct: the size, then the members' offsets in order


@functools.cache
def host_source() -> str:
    rows = []
    for name, inside in STRUCTS.items():
        offsets = "".join(f", offsetof({name}, {member})" for member in inside)
        rows.append(
            f'printf("%s\\"{name}\\": [%zu{", %zu" * len(inside)}]", comma, sizeof({name}){offsets}), comma = ", ";'
        )
    return '#include "types.h"\n#include <stddef.h>\n#include <stdio.h>\nint main(void) {\nconst char *comma = "{";\n' + "\n".join(
        [*rows, 'puts("}");\nreturn 0;\n}\n']
    )  # fmt: skip


@pytest.fixture(scope="module")
def on_host(tmp_path_factory: pytest.TempPathFactory) -> Layout:
    folder = tmp_path_factory.mktemp("layout")
    (folder / "layout.c").write_text(host_source())
    compiler = shlex.split(os.environ.get("CC", "gcc"))
    flags = ["-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Werror", f"-I{ROOT / 'kernels'}"]
    subprocess.run([*compiler, *flags, "-o", folder / "layout", folder / "layout.c"], check=True)
    done = subprocess.run([folder / "layout"], check=True, capture_output=True, text=True)
    return dict(json.loads(done.stdout))


def on_device(queue: Any, options: list[str]) -> Layout:
    """Measured by pointers, between elements of an array and to members, in a kernel's own memory."""
    import pyopencl as cl

    lines = []
    for name, inside in STRUCTS.items():
        lines.append(f"{{ {name} a[2]; *out++ = (uint)((uchar *)(a + 1) - (uchar *)a);")
        lines += [f"*out++ = (uint)((uchar *)&a->{member} - (uchar *)a);" for member in inside]
        lines.append("}")
    count = len(STRUCTS) + sum(map(len, STRUCTS.values()))
    source = TYPES + "\nkernel void measure(global uint *out) {\n" + "\n".join(lines) + "\n}\n"
    program = cl.Program(queue.context, source).build(options)
    found = np.zeros(count, np.uint32)
    buffer = cl.Buffer(queue.context, cl.mem_flags.WRITE_ONLY, found.nbytes)
    program.measure(queue, (1,), None, buffer)
    cl.enqueue_copy(queue, found, buffer)
    numbers = iter(found.tolist())
    return {name: [next(numbers) for _ in range(1 + len(inside))] for name, inside in STRUCTS.items()}


def whole_of(name: str) -> bool:
    """Whether a struct is of real numbers throughout; the others are of whole ones."""
    kinds = {kind.startswith("uint4") for kind in STRUCTS[name].values()}
    assert len(kinds) == 1, f"{name} mixes reals and integers: narrowing would break it"
    return kinds == {False}


def test_double_is_as_on_the_host(queue: Any, on_host: Layout) -> None:
    assert on_device(queue, ["-DDOUBLE"]) == on_host


def test_float_is_the_host_narrowed(queue: Any, on_host: Layout) -> None:
    """An array of reals is narrowed without a look at what is in it: every size and offset halves."""
    expected = {name: [n // 2 for n in sizes] if whole_of(name) else sizes for name, sizes in on_host.items()}
    assert on_device(queue, []) == expected


def lengths_of(kind: str) -> tuple[int, ...]:
    """Of an array's type."""
    return tuple(map(int, re.findall(r"\[(\d+)\]", kind)))


def assignments(name: str, path: str, first: int) -> tuple[list[str], int]:
    """C that fills a struct with the numbers from `first` on, and the number after the last."""
    lines = []
    for member, kind in STRUCTS[name].items():
        target = f"{path}.{member}"
        if kind in STRUCTS:
            inner, first = assignments(kind, target, first)
            lines += inner
            continue
        for place in np.ndindex(lengths_of(kind)):
            count = 4 if kind in ("real4", "uint4") else 1
            numbers = ", ".join(str(first + i) for i in range(count))
            lines.append(f"{target}{''.join(f'[{i}]' for i in place)} = ({kind.partition('[')[0]})({numbers});")
            first += count
    return lines, first


def flatten(value: Any) -> list[float]:
    if value.dtype.names is None:
        return [float(n) for n in value.ravel()]
    return [n for member in value.dtype.names for n in flatten(value[member])]


@pytest.mark.parametrize(("options", "real"), [(["-DDOUBLE"], np.float64), ([], np.float32)])
def test_numpy_reads_what_the_device_writes(queue: Any, on_host: Layout, options: list[str], real: Any) -> None:
    """Every number of every struct is written under its own name, and found by a dtype made of the host's offsets."""
    import pyopencl as cl

    @functools.cache
    def dtype(name: str) -> np.dtype[Any]:
        if name in ("real4", "uint4"):
            return np.dtype((real if name == "real4" else np.uint32, 4))
        if "[" in name:
            return np.dtype((real, lengths_of(name)))
        scale = 2 if whole_of(name) and real is np.float32 else 1
        size, *offsets = (n // scale for n in on_host[name])
        formats = [dtype(kind) for kind in STRUCTS[name].values()]
        return np.dtype({"names": list(STRUCTS[name]), "formats": formats, "offsets": offsets, "itemsize": size})

    source = TYPES
    for name in STRUCTS:
        body = "\n".join(assignments(name, "out[1]", 1)[0])
        source += f"\nkernel void write_{name}(global {name} *out) {{\n{body}\n}}\n"
    program = cl.Program(queue.context, source).build(options)
    for name in STRUCTS:
        found = np.zeros(2, dtype(name))
        buffer = cl.Buffer(queue.context, cl.mem_flags.COPY_HOST_PTR, hostbuf=found)
        getattr(program, f"write_{name}")(queue, (1,), None, buffer)
        cl.enqueue_copy(queue, found, buffer)
        count = assignments(name, "", 1)[1]
        assert flatten(found[1]) == list(range(1, count)), name
        assert not any(flatten(found[0])), name
