"""Masks as bits and back, the least and greatest of the lanes, and rows of entries: every width in both precisions."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from blocks import WIDTH
from shapes import LEVELS, REAL, only

import feeler

WIDTHS = [1, 2, 4, 8, 16]
KERNELS = """
#define AT get_global_id(0)
kernel void run_bits(global const ints *m, global uint *out) { out[AT] = lane_bits(m[AT]); }
kernel void run_any(global const ints *m, global uint *out) { out[AT] = any_lane(m[AT]); }
kernel void run_masks(global const uint *bits, global ints *out) { out[AT] = mask_of_bits(bits[AT]); }
kernel void run_lowest(global const uint *bits, global uint *out) { out[AT] = lowest_bit(bits[AT]); }
kernel void run_least(global const reals *a, global real *out) { out[AT] = least_lane(a[AT]); }
kernel void run_greatest(global const reals *a, global real *out) { out[AT] = greatest_lane(a[AT]); }
kernel void run_row(global const real *row, global reals *out) { out[AT] = load_row(row, AT * CHUNK); }
"""
Run = Callable[[str, Any, Any, int], Any]


@pytest.fixture(scope="module", params=[(lanes, level) for lanes in WIDTHS for level in LEVELS], ids=str)
def build(request: pytest.FixtureRequest) -> tuple[int, str]:
    return tuple(request.param)  # type: ignore[return-value]


@pytest.fixture(scope="module")
def run(build: tuple[int, str], queue: Any) -> Run:
    """Runs a kernel by name over an array, for so many work-items; the result is of the shape and type of `like`."""
    import pyopencl as cl

    lanes, level = build
    options = f"-cl-std=CL1.2 -DLANES={lanes} {'-DDOUBLE' if level == 'reference' else ''} {only()}"
    program = cl.Program(queue.context, feeler.kernel_source() + KERNELS).build(options)

    def run(name: str, values: Any, like: Any, items: int) -> Any:
        found = np.full_like(like, 77)
        flags = cl.mem_flags.COPY_HOST_PTR
        buffers = [cl.Buffer(queue.context, flags, hostbuf=np.ascontiguousarray(array)) for array in (values, found)]
        cl.Kernel(program, f"run_{name}")(queue, (items,), (1,), *buffers)
        cl.enqueue_copy(queue, found, buffers[1])
        return found

    return run


def masks(build: tuple[int, str]) -> tuple[Any, Any]:
    """Every mask, or many, as bits and as lanes: true is 1 in one lane and -1 in many, as comparisons make it."""
    lanes, level = build
    bits = np.arange(1 << lanes, dtype=np.uint32)
    if lanes == 16:
        bits = np.concatenate([bits[:3], bits[-3:], 1 << bits[:16], np.random.default_rng(61).choice(bits, 500)])
    in_lanes = (bits[:, None] >> np.arange(lanes, dtype=np.uint32) & 1).astype("i4" if level == "standard" else "i8")
    return bits.astype(np.uint32), in_lanes if lanes == 1 else -in_lanes


def test_bits_of_masks(build: tuple[int, str], run: Run) -> None:
    bits, in_lanes = masks(build)
    assert np.array_equal(run("bits", in_lanes, bits, len(bits)), bits)
    assert np.array_equal(run("any", in_lanes, bits, len(bits)), bits != 0)


def test_masks_of_bits(build: tuple[int, str], run: Run) -> None:
    """Bits beyond the lanes count for nothing."""
    bits, in_lanes = masks(build)
    more = bits | np.uint32(0x80000000) | np.uint32(1 << build[0])
    for given in (bits, more):
        assert np.array_equal(run("masks", given, in_lanes, len(bits)), in_lanes)


def test_the_lowest_bit(run: Run) -> None:
    bits = np.concatenate([np.arange(1, 300), 1 << np.arange(32), 0xFFFFFFFF << np.arange(32)]).astype(np.uint32)
    lowest = run("lowest", bits, bits, len(bits))
    assert np.array_equal(np.uint32(1) << lowest, bits & (~bits + np.uint32(1)))


def test_least_and_greatest_lanes(build: tuple[int, str], run: Run) -> None:
    lanes, level = build
    rng = np.random.default_rng(62)
    values = rng.normal(size=(1000, lanes)) * 10.0 ** rng.integers(-30, 30, (1000, lanes))
    values[rng.random(values.shape) < 0.1] = np.inf
    values[rng.random(values.shape) < 0.1] = -np.inf
    values = values.astype(REAL[level])
    assert np.array_equal(run("least", values, values[:, 0], 1000), values.min(1))
    assert np.array_equal(run("greatest", values, values[:, 0], 1000), values.max(1))


def test_entries_of_a_row(build: tuple[int, str], run: Run) -> None:
    """As many as there are lanes at a time; lanes beyond a row's end hold entries of it again."""
    lanes, level = build
    row = np.concatenate([np.arange(WIDTH), np.full(16, 99)]).astype(REAL[level])
    chunk = min(lanes, WIDTH)
    expected = (np.arange(0, WIDTH, chunk)[:, None] + np.arange(lanes) % chunk).astype(REAL[level])
    assert np.array_equal(run("row", row, expected, WIDTH // chunk), expected)
