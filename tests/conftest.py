"""What the tests share: paths, the program, devices. Nothing here knows what is tested."""

from __future__ import annotations

import os
import subprocess
import tempfile
from pathlib import Path
from typing import Any

import hypothesis
import pytest
from places import BUILD, ROOT

# What a user keeps (`feeler bench --save`) must not change a test: an empty folder of configuration.
os.environ["XDG_CONFIG_HOME"] = tempfile.mkdtemp(prefix="feeler-config-")
os.environ.pop("FEELER_TUNED", None)

# PoCL's cache of compiled kernels is not safe between processes: each worker of xdist has its own, and keeps it.
if worker := os.environ.get("PYTEST_XDIST_WORKER"):
    cache = Path(os.environ.get("POCL_CACHE_DIR", BUILD / "kernel-cache")).resolve() / worker
    cache.mkdir(parents=True, exist_ok=True)
    os.environ["POCL_CACHE_DIR"] = str(cache)

# A kernel's first compilation takes seconds, and a failing example must be found again: no deadline, no chance.
hypothesis.settings.register_profile("feeler", deadline=None, derandomize=True, max_examples=50, database=None)
hypothesis.settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "feeler"))


# What one worker of xdist does: a file's tests share kernels, and so do those of the first group. What takes longest begins.
GROUPS = [
    ("test_primitives", "test_polygons", "test_optics"),
    ("test_invariants", "test_guarantees"), ("test_reintersection", "test_watertight"), ("test_stability",), ("test_instances",),
    ("test_packets",), ("test_scenes",), ("test_probe",), ("test_python",),
]  # fmt: skip


# What takes longest and says least that nothing shorter says: for `make test-long`.
LONG = [
    "test_accuracy.py::test_methods",
    "test_cli_interactive.py::test_interruption[15]",
    "test_cli_pictures.py::test_discarded_weight_shrinks_with_depth",
    "test_counting.py::test_steps_are_counted[16]",
    "test_counting.py::test_steps_are_counted[1]",
    "test_empty_scenes.py::test_without_lights_there_are_ambient_and_emission[{'level': 'draft'}]",
    "test_empty_scenes.py::test_without_lights_there_are_ambient_and_emission[{'level': 'reference'}]",
    "test_empty_scenes.py::test_without_objects_there_is_the_background[{'level': 'draft'}]",
    "test_empty_scenes.py::test_without_objects_there_is_the_background[{'level': 'reference'}]",
    "test_guarantees.py::test_crossings_in_any_power_of_two[convex polygon]",
    "test_guarantees.py::test_crossings_in_any_power_of_two[disc]",
    "test_guarantees.py::test_crossings_in_any_power_of_two[open cylinder]",
    "test_guarantees.py::test_crossings_in_any_power_of_two[open pointed cone]",
    "test_guarantees.py::test_crossings_in_any_power_of_two[open truncated cone]",
    "test_guarantees.py::test_rays_through_glass_find_back[box-reference]",
    "test_guarantees.py::test_rays_through_glass_find_back[cylinder-reference]",
    "test_guarantees.py::test_rays_through_glass_find_back[sphere-reference]",
    "test_guarantees.py::test_rays_through_glass_find_back[truncated cone-reference]",
    "test_instances.py::test_an_ellipsoid_is_its_quadric[0-standard]",
    "test_instances.py::test_an_ellipsoid_is_its_quadric[1-standard]",
    "test_instances.py::test_an_ellipsoid_is_its_quadric[2-standard]",
    "test_instances.py::test_an_ellipsoid_is_its_quadric[3-standard]",
    "test_instances.py::test_an_ellipsoid_is_its_quadric[5-standard]",
    "test_instances.py::test_lanes",
    "test_instances.py::test_lanes_with_filtered_shadows",
    "test_instances.py::test_the_identity_is_nothing[reference]",
    "test_instances.py::test_the_same_bits[options2]",
    "test_invariants.py::test_brute_force_is_the_tree[reference]",
    "test_invariants.py::test_every_number_of_lanes",
    "test_invariants.py::test_lanes[draft-8-False]",
    "test_invariants.py::test_lanes[reference-4-True]",
    "test_invariants.py::test_lanes[standard-16-False]",
    "test_invariants.py::test_pixels_without_a_hit[1-pixels2]",
    "test_invariants.py::test_scaled_in_double",
    "test_invariants.py::test_several_pixels_of_a_work_item",
    "test_invariants.py::test_specialised_is_general[specular transmission with",
    "test_invariants.py::test_specialised_is_general[without shadows]",
    "test_invariants.py::test_work_groups[work_group1]",
    "test_invariants.py::test_work_groups[work_group3]",
    "test_invariants.py::test_work_groups[work_group4]",
    "test_margin.py::test_margin_beside_an_edge[box]",
    "test_margin.py::test_margin_beside_an_edge[polygon]",
    "test_margin.py::test_margins_do_not_depend_on_the_tree",
    "test_margin.py::test_total_reflection_beyond_its_bound_is_right",
    "test_margin.py::test_what_a_ball_turns_beyond_its_bound_is_right[reflection]",
    "test_margin.py::test_whole_trees_beyond_their_bounds_are_right",
    "test_meshes.py::test_a_cube_is_a_box[near the axis-False-reference]",
    "test_meshes.py::test_shells_within_shells[out]",
    "test_packets.py::test_a_beam_leaves_out_no_box_that_a_ray_meets[16-standard]",
    "test_packets.py::test_a_beam_leaves_out_no_box_that_a_ray_meets[2-",
    "test_packets.py::test_a_beam_leaves_out_no_box_that_a_ray_meets[4-",
    "test_packets.py::test_a_row_of_boxes_is_met_like_each[1-reference]",
    "test_packets.py::test_a_row_of_boxes_is_met_like_each[8-reference]",
    "test_packets.py::test_boxes_side_by_side_are_boxes_alone[16-16]",
    "test_packets.py::test_boxes_side_by_side_are_boxes_alone[2-8]",
    "test_packets.py::test_boxes_side_by_side_are_boxes_alone[8-8]",
    "test_packets.py::test_every_way_finds_the_same[reference",
    "test_packets.py::test_every_way_finds_the_same[standard-1-1-False]",
    "test_packets.py::test_every_way_finds_the_same[standard-16-1-True]",
    "test_packets.py::test_every_way_finds_the_same[standard-2-1-True]",
    "test_packets.py::test_every_way_finds_the_same[standard-2-2-True]",
    "test_packets.py::test_every_way_finds_the_same[standard-4-",
    "test_packets.py::test_every_way_finds_the_same[standard-8-1-False]",
    "test_packets.py::test_every_way_finds_the_same[standard-8-1-True]",
    "test_packets.py::test_every_way_finds_the_same[standard-8-8-False]",
    "test_packets.py::test_the_rays_are_worth_it[reference]",
    "test_pixel_terms.py::test_the_same_as_the_picture[16]",
    "test_primitives.py::test_rays_inside_a_sphere_meet_its_other_side[reference]",
    "test_probe.py::test_lanes_never_change_bits",
    "test_probe.py::test_results_are_arguments[1",
    "test_probe.py::test_results_are_arguments[8-draft]",
    "test_probe.py::test_results_are_arguments[8-reference]",
    "test_python.py::test_settings_that_never_change_the_picture",
    "test_scenes.py::test_float_against_double[first]",
    "test_scenes.py::test_float_against_double[mirror-room]",
    "test_scenes.py::test_float_against_double[night]",
    "test_scenes.py::test_float_against_double[still-life]",
    "test_stability.py::test_a_row_of_the_catalogue[1-",
    "test_stability.py::test_a_row_of_the_catalogue[10-",
    "test_stability.py::test_a_row_of_the_catalogue[11-",
    "test_stability.py::test_a_row_of_the_catalogue[12-",
    "test_stability.py::test_a_row_of_the_catalogue[13-",
    "test_stability.py::test_a_row_of_the_catalogue[14-",
    "test_stability.py::test_a_row_of_the_catalogue[17-",
    "test_stability.py::test_a_row_of_the_catalogue[2-",
    "test_stability.py::test_a_row_of_the_catalogue[23-",
    "test_stability.py::test_a_row_of_the_catalogue[26-",
    "test_stability.py::test_a_row_of_the_catalogue[3-",
    "test_stability.py::test_a_row_of_the_catalogue[4-",
    "test_stability.py::test_a_row_of_the_catalogue[5-",
    "test_stability.py::test_a_row_of_the_catalogue[6-",
    "test_stability.py::test_a_row_of_the_catalogue[7-",
    "test_stability.py::test_a_row_of_the_catalogue[8-",
    "test_stability.py::test_a_row_of_the_catalogue[9-",
    "test_terminator.py::test_the_same_bits_by_every_way",
    "test_watertight.py::test_closed_meshes_have_no_holes[centre0-1.0-False-apart]",
    "test_watertight.py::test_closed_meshes_have_no_holes[centre1-2.0-False-apart]",
    "test_watertight.py::test_closed_meshes_have_no_holes[centre1-2.0-True-apart]",
    "test_watertight.py::test_closed_meshes_have_no_holes[centre2-0.001-False-apart]",
    "test_whole_scenes.py::test_specialised_is_general",
    "test_work_groups.py::test_a_crash_is_a_row",
    "test_work_groups.py::test_the_best_is_kept_for_scenes_that_are_alike",
    "test_work_groups.py::test_the_product_of_lists",
    "test_work_groups.py::test_what_render_refuses_is_marked_and_not_kept",
]


@pytest.hookimpl(tryfirst=True)  # before -m leaves the slow ones out
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    def group(item: pytest.Item) -> int:
        return next((i for i, files in enumerate(GROUPS) if item.path.stem in files), len(GROUPS))

    items.sort(key=group)
    for item in items:
        if any(long in item.nodeid for long in LONG):
            item.add_marker(pytest.mark.slow)
        shares = GROUPS[group(item)][0] if group(item) < len(GROUPS) else item.path.stem
        item.add_marker(pytest.mark.xdist_group(shares))


@pytest.fixture(scope="session")
def root() -> Path:
    """The checkout."""
    return ROOT


@pytest.fixture(scope="session")
def scenes(root: Path) -> Path:
    """The folder of the scenes that come with feeler."""
    return root / "scenes"


@pytest.fixture(scope="session")
def spd() -> Path:
    """The folder of the classic databases (balls.nff …): $FEELER_SPD, or beside the checkout."""
    folder = Path(os.environ.get("FEELER_SPD", ROOT.parent / "shared" / "spd"))
    if not (folder / "balls.nff").is_file():
        pytest.skip(f"the classic scenes are not in {folder}: set FEELER_SPD to the folder of balls.nff")
    return folder


@pytest.fixture(scope="session")
def peers() -> Path:
    """The folder of the programs to compare with: $FEELER_PEERS, or beside the checkout."""
    folder = Path(os.environ.get("FEELER_PEERS", ROOT.parent / "shared" / "peers"))
    if not folder.is_dir():
        pytest.skip(f"there is no {folder}: set FEELER_PEERS to the folder of the programs to compare with")
    return folder


@pytest.fixture(scope="session")
def program() -> Path:
    """The command-line program."""
    path = BUILD / "feeler"
    if not path.is_file():
        pytest.fail(f"{path} is missing: run `make`")
    return path


@pytest.fixture
def cli(program: Path, tmp_path: Path) -> Any:
    """Runs the program with arguments, in a fresh folder; the result has returncode, stdout and stderr."""

    def run(*arguments: Any, **options: Any) -> subprocess.CompletedProcess[str]:
        command = [str(program), *map(str, arguments)]
        options = {"cwd": tmp_path, "capture_output": True, "text": True, "timeout": 300, **options}
        return subprocess.run(command, check=False, **options)

    return run


@pytest.fixture(scope="session")
def queue() -> Any:
    """A pyopencl queue on PoCL's CPU device."""
    cl = pytest.importorskip("pyopencl")
    try:
        platforms = cl.get_platforms()
    except cl.Error:
        platforms = []
    for platform in platforms:
        if platform.name == "Portable Computing Language":
            return cl.CommandQueue(cl.Context(platform.get_devices()[:1]))
    pytest.skip("there is no PoCL: install pocl-opencl-icd")
