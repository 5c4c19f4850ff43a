"""probe: single functions of the kernels over arrays, every kind of parameter and result."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from shapes import only

import feeler
from feeler._layout import Layout
from feeler._prototypes import read_prototypes

PLAIN = only()  # builds in a second; without options everything is built
SPHERE = only("SPHERE")
ORIGINS = np.array([[0, 0, 5], [0.5, 0, 5], [3, 0, 5], [0, 0.25, 5], [9, 0, 5.0]])
SPHERES = np.array([[0, 0, 0, 1, -1, -1, -1, 0, 1, 1, 1, 0], [3, 0, 0, 0.5, 2.5, -0.5, -0.5, 0, 3.5, 0.5, 0.5, 0]])


def test_numbers_broadcast() -> None:
    x = np.array([[1.0], [2.0], [3.0]])
    result = feeler.probe("difference_of_products", x, [4.0, 5.0], 1, 2)
    assert result.shape == (3, 2)
    assert result.dtype == np.float32
    assert np.array_equal(result, x * [4, 5] - 2)
    assert feeler.probe("difference_of_products", 1, 2, 3, 4).shape == ()


def test_reference_is_float64() -> None:
    result = feeler.probe("difference_of_products", 0.1, 1, 0, 0, level="reference")
    assert result.dtype == np.float64
    assert result == 0.1


@given(st.lists(st.floats(-1e3, 1e3, width=32), min_size=1, max_size=40), st.sampled_from([1, 2, 4, 8, 16]))
def test_lanes_never_change_bits(values: list[float], lanes: int) -> None:
    arguments = (values, values[::-1], 0.5, [values[0]])
    wide = feeler.probe("difference_of_products", *arguments, lanes=lanes, options=PLAIN)
    assert np.array_equal(wide, feeler.probe("difference_of_products", *arguments, options=PLAIN))


@pytest.mark.parametrize("lanes", [1, 4])
def test_vectors_and_structs(lanes: int) -> None:
    cross = feeler.probe("cross3", [1.0, 0, 0], [[0, 1.0, 0], [0, 0, 1]], lanes=lanes, options=PLAIN)
    assert np.array_equal(cross, [[0, 0, 1], [0, -1, 0]])
    as_members = feeler.probe("cross3", (1, 0, 0), {"x": [0, 0], "y": [1, 0], "z": [0, 1]}, lanes=lanes, options=PLAIN)
    assert np.array_equal(as_members, cross)
    quads = feeler.probe("splat_xyz", [[1, 2, 3, 4]], lanes=1, options=PLAIN)
    assert np.array_equal(quads, [[1, 2, 3]])


def test_structured_arrays() -> None:
    vectors = np.zeros(2, [("x", "f4"), ("y", "f4"), ("z", "f4")])
    vectors["x"] = 1
    assert np.array_equal(feeler.probe("cross3", vectors, [0.0, 1, 0], options=PLAIN), [[0, 0, 1]] * 2)


@pytest.mark.parametrize("level", ["draft", "standard", "reference"])
@pytest.mark.parametrize("lanes", [1, 8])
def test_results_are_arguments(level: str, lanes: int) -> None:
    options: dict[str, Any] = {"level": level, "lanes": lanes, "options": SPHERE}
    ray = feeler.probe("make_ray", ORIGINS, [0, 0, -1.0], **options)
    assert ray.origin.shape == (5, 3)
    crossing = feeler.probe("intersect_sphere", ray, [0, 0, 0.0], 1.0, 0, **options)
    assert list(crossing.found != 0) == [True, True, False, True, False]
    assert crossing.distance[0] == 4


@pytest.mark.parametrize("lanes", [1, 4])
def test_a_whole_scene_as_a_dict_of_tables(lanes: int) -> None:
    fields = SPHERES[:, [4, 5, 6, 8, 9, 10, 0, 1, 2, 3]]  # box, centre, radius
    scene = {
        "primitives": [[0, 0, 0, 0], [0, 1, 0, 0]],
        "spheres": SPHERES,
        "blocks": fields[[0, 1, 1, 1, 1, 1, 1, 1]].T.ravel(),
        "block_numbers": [0, 1, 1, 1, 1, 1, 1, 1],
        "links": [[0, 0]],
        "count": [0, 1, 0, 0],
    }
    ray = feeler.probe("make_ray", ORIGINS, [0, 0, -1.0], lanes=lanes, options=SPHERE)
    hit = feeler.probe("closest_hit", scene, ray, True, lanes=lanes, options=SPHERE)
    assert list(hit.primitive) == [0, 0, 1, 0, -1]
    assert hit.distance[2] == 4.5


def test_global_pointers_take_whole_arrays() -> None:
    table = np.arange(16)
    quads = feeler.probe("gather", table, [2, 0, 1], 4, lanes=2, options=PLAIN)
    assert np.array_equal(quads.w, [11, 3, 7])


def test_masks_and_results_without_lanes() -> None:
    mask = [True, False, True, False, False, False]
    assert np.array_equal(feeler.probe("any_lane", mask, lanes=2, options=PLAIN), [1, 1, 0])
    assert np.array_equal(feeler.probe("lane_bits", mask, lanes=4, options=PLAIN), [0b0101, 0])


def test_one_ray_is_in_all_lanes() -> None:
    rows = np.arange(16.0)
    near = feeler.probe("least_lane", [3.0, 1, 2], lanes=4, options=f"{PLAIN} -DRAYS=1")
    assert np.array_equal(near, [3, 1, 2])
    assert np.array_equal(feeler.probe("gather", rows, [2, 0], 4, lanes=4, options=f"{PLAIN} -DRAYS=1").w, [11, 3])


def test_what_varies_without_lanes_has_a_work_item_each() -> None:
    result = feeler.probe("splat_xyz", np.arange(12).reshape(3, 4), lanes=4, options=PLAIN)
    assert np.array_equal(result, [[0, 1, 2], [4, 5, 6], [8, 9, 10]])


@pytest.mark.parametrize(
    ("name", "arguments", "text"),
    [
        ("croos3", (), "did you mean 'cross3'"),
        ("cross3", (1,), "takes 2 arguments (a, b), not 1"),
        ("cross3", ([1, 2], [1, 2, 3]), "a: the shape is (2,), not (…, 3)"),
        ("cross3", ((1, 2), [1, 2, 3]), "2 items given, 3 needed"),
        ("cross3", ({"x": 1, "y": 2, "w": 3}, [1, 2, 3]), "members w, z are unknown or missing"),
        ("dot3", (np.zeros((2, 3)), np.zeros((4, 3))), "do not broadcast"),
        ("dot3", (np.zeros((0, 3)), np.zeros(3)), "no elements"),
        ("splat", ("one",), "splat: x"),
        ("gather", (np.zeros((3, 2)), 0, 4, 5), "takes 3"),
        ("any_lane", (1j,), "numbers are needed"),
    ],
)
def test_mistakes_are_clear(name: str, arguments: tuple[Any, ...], text: str) -> None:
    with pytest.raises(feeler.Error) as caught:
        feeler.probe(name, *arguments)
    assert text in str(caught.value)


def test_a_build_failure_has_its_log() -> None:
    with pytest.raises(feeler.Error) as caught:
        feeler.probe("splat", 1, options="-Dsplat=nonsense(")
    assert caught.value.kind == "device"
    assert "lanes.cl" in caught.value.log


def test_a_given_queue(queue: Any) -> None:
    assert feeler.probe("dot3", [1, 2, 3], [4, 5, 6], queue=queue) == 32


def test_a_queue_without_order(queue: Any) -> None:
    cl = pytest.importorskip("pyopencl")
    properties = cl.command_queue_properties.OUT_OF_ORDER_EXEC_MODE_ENABLE
    if not queue.device.queue_properties & properties:
        pytest.skip("the device has no queue without order")
    unordered = cl.CommandQueue(queue.context, properties=properties)
    # The first launch compiles; a read that did not wait would be done by then.
    never_built = f"-DNEVER_BUILT={time.time_ns()}"
    assert feeler.probe("dot3", [1, 2, 3], [4, 5, 6], queue=unordered, options=f"{PLAIN} {never_built}") == 32


# ---- the reader of prototypes, on a source of its own

SOURCE = """
#define MEDIA 3 // at most
#define INLINE __attribute__((always_inline))
typedef struct { reals x, y, z; } vectors;
/* typedef struct { int no; } no; */
typedef struct { vectors at[2]; ints media[MEDIA], last; real rows[2][3]; global const real4 *table; } thing;
#if 1
static inline reals first(const thing t,
                          private thing *u, __global const uint4 *table)
{
    if (1) { return 0; }
}
#endif
kernel void entry(global real *out) { }
INLINE void nothing(void) { }
"""


def test_prototypes() -> None:
    found = read_prototypes(SOURCE, "-DMEDIA=2 -DLANES=4")
    assert set(found.functions) == {"first", "nothing"}
    assert set(found.structs) == {"vectors", "thing"}
    first = found.function("first")
    assert first.returns == "reals"
    described = [(p.name, p.type, p.space, p.constant) for p in first.parameters]
    assert described == [("t", "thing", "", True), ("u", "thing", "private", False), ("table", "uint4", "global", True)]
    assert found.function("nothing").parameters == ()
    assert found.function("nothing").returns == "void"
    layout = Layout(found, lanes=1, double=False)
    paths = [leaf.path for leaf in layout.leaves("thing")]
    assert paths[:3] == [".at[0].x", ".at[0].y", ".at[0].z"]
    assert paths[6:9] == [".media[0]", ".media[1]", ".last"]
    assert paths[9:] == [f".rows[{i}][{j}]" for i in range(2) for j in range(3)]
    assert [path for path, _ in layout.tables("thing")] == [".table"]


def test_arrays_in_structs_split_and_join() -> None:
    layout = Layout(read_prototypes(SOURCE, ""), lanes=1, double=False)
    value = (np.arange(12.0).reshape(2, 2, 3), np.arange(6).reshape(2, 3), [7, 8], np.arange(12).reshape(2, 2, 3), None)
    parts = layout.split("thing", value, "t")
    assert [part.shape for part in parts] == [(2,)] * 16
    joined = layout.join("thing", iter(parts))
    assert np.array_equal(joined.media, value[1])
    assert np.array_equal(joined.at[1], value[0][:, 1])
    assert list(joined.last) == [7, 8]
    assert np.array_equal(joined.rows, value[3])
    flat = layout.split("thing", (*value[:3], value[3].reshape(2, 6), None), "t")
    assert all(np.array_equal(a, b) for a, b in zip(parts, flat, strict=True))
