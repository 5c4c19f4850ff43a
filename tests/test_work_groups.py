"""feeler bench: sweeps of work groups, what a size may do wrong, files of results, and keeping the best."""

from __future__ import annotations

import csv
import io
import json
import os
import re
import shlex
import signal
import subprocess
import time
from pathlib import Path
from typing import Any

import jsonschema
import pytest
from pictures import everything
from places import ROOT
from spheres import write_spheres
from t4 import SCHEMA

import feeler

FAST = ["--size", "32x24", "--repeat", "3", "--work-groups", "2x2,8x8,16x4"]


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    return write_spheres(tmp_path / "spheres.nff")


def sweep(cli: Any, *arguments: Any, code: int = 0) -> list[dict[str, Any]]:
    """The results as JSON, which must follow the schema."""
    result = cli("bench", *arguments, "--json", "-")
    assert result.returncode == code, result.stderr
    results = json.loads(result.stdout)
    jsonschema.validate(results, SCHEMA)
    assert results["schema_version"] == "1.0.0"
    return list(results["results"])


def size_of(result: dict[str, Any]) -> tuple[int, int]:
    return result["configuration"]["work_group_x"], result["configuration"]["work_group_y"]


def measured(result: dict[str, Any]) -> dict[str, Any]:
    return {one["name"]: one["value"] for one in result["measurements"]}


# ---- sweeps ----


def test_a_sweep(cli: Any, scene: Path) -> None:
    """The default is there, once and first; each size rendered as often as asked for, and the same picture."""
    results = sweep(cli, scene, *FAST)
    default = tuple(feeler.load(scene).render(size=(32, 24)).stats["work_group"])
    others = [size for size in [(2, 2), (8, 8), (16, 4)] if size != default]
    assert [size_of(result) for result in results] == [default, *others]
    assert [measured(result)["default"] for result in results] == [1] + [0] * len(others)
    for result in results:
        times = result["times"]["runtimes"]
        assert (result["invalidity"], result["correctness"], len(times)) == ("correct", 1, 3)
        values = measured(result)
        assert values["time"] == sorted(times)[1]
        assert (values["time_min"], values["time_max"]) == (min(times), max(times))
        assert 0 < values["time_min"] <= values["wall"]
        assert result["configuration"] | {"width": 32, "height": 24, "level": "standard"} == result["configuration"]


def test_the_product_of_lists(cli: Any, tmp_path: Path, scene: Path) -> None:
    other = write_spheres(tmp_path / "other.nff")
    lists = ["--samples", "1,4", "--level", "draft,standard", "--device", "0,portable", "--repeat", "1"]
    results = sweep(cli, scene, other, *FAST, *lists, "--warm-up", "0", "--work-groups", "8x8")
    cases = {
        tuple(result["configuration"][key] for key in ("scene", "samples", "level"))
        for result in results
    }  # fmt: skip
    assert len(cases) == 8
    assert len(results) in (16, 32), "two devices, with one or two sizes"
    assert all(result["invalidity"] == "correct" for result in results)


def test_the_table(cli: Any, scene: Path) -> None:
    result = cli("bench", scene, *FAST, "--work-groups", "2x2,100000x1,16x4")
    assert result.returncode == 0, result.stderr
    assert re.search(r"^\* 8x8 +[\d.]+ +[\d.]+ +[\d.]+ +1\.00 +[\d.]+ +[\d.]+$", result.stdout, re.MULTILINE)
    assert re.search(r"^  2x2 +[\d.]+ ", result.stdout, re.MULTILINE)
    assert re.search(r"^  100000x1 +invalid: .*work-items", result.stdout, re.MULTILINE)
    assert re.search("^  (best: |no size is faster)", result.stdout, re.MULTILINE)
    assert result.stderr == ""
    assert cli("bench", scene, *FAST, "--repeat", "1", "--quiet").stdout == ""


def test_what_is_kept_does_not_change_the_default(cli: Any, scene: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    kept = scene.parent / "kept.yaml"
    monkeypatch.setenv("FEELER_TUNED", str(kept))
    assert cli("bench", scene, *FAST, "--save").returncode == 0
    kept.write_text(re.sub(r"work_group: .*", "work_group: [3, 5]", kept.read_text()))
    assert feeler.load(scene).render().stats["work_group"] == [3, 5]
    assert size_of(sweep(cli, scene, *FAST, "--work-groups", "2x2")[0]) == (8, 8)


def test_csv_and_json_agree(cli: Any, tmp_path: Path, scene: Path) -> None:
    (tmp_path / 'a "b", c.nff').write_text(scene.read_text())
    scenes = ["spheres.nff", 'a "b", c.nff']
    done = cli("bench", *scenes, *FAST, "--work-groups", "2x2,100000x1", "--json", "a.json", "--csv", "a.csv")
    assert done.returncode == 0, done.stderr
    results = json.loads((tmp_path / "a.json").read_text())["results"]
    rows = list(csv.DictReader(io.StringIO((tmp_path / "a.csv").read_text(), newline=""), strict=True))
    assert len(rows) == len(results) == 6
    assert [row["scene"] for row in rows] == [scenes[0]] * 3 + [scenes[1]] * 3
    for row, result in zip(rows, results, strict=True):
        values = measured(result)
        for key in ("scene", "device", "level", "samples", "width", "height", "lanes", "work_group_x", "work_group_y"):
            assert row[key] == str(result["configuration"][key]), key
        for key in ("default", "forced"):
            assert row[key] == str(values[key])
        for key in ("time", "time_min", "time_max", "wall", "wall_min", "wall_max"):
            assert row[f"{key}_ms"] == "" if key not in values else float(row[f"{key}_ms"]) == values[key]
        assert row["invalidity"] == result["invalidity"]
        assert float(row["correctness"]) == result["correctness"]
        assert float(row["compilation_ms"]) == result["times"]["compilation_time"]
        assert int(row["repeats"]) == len(result["times"]["runtimes"])
        assert row["detail"] == values.get("detail", "")


# ---- what goes wrong with a size ----


def test_a_size_that_the_device_does_not_take(cli: Any, scene: Path) -> None:
    result = sweep(cli, scene, *FAST, "--work-groups", "100000x1")[-1]
    assert (result["invalidity"], result["correctness"]) == ("constraints", 0)
    assert result["times"]["runtimes"] == []
    assert "at most" in measured(result)["detail"]


def write_deep_scene(path: Path) -> Path:
    """A scene whose kernel takes so much of a thread's stack that a large group of it crashes PoCL's device."""
    path.write_text(json.dumps({**everything(), "depth": 128, "image": {"size": [64, 64]}}))
    return path


def test_a_crash_is_a_row(cli: Any, tmp_path: Path) -> None:
    deep = write_deep_scene(tmp_path / "deep.yaml")
    results = sweep(cli, deep, "--samples", "16", "--repeat", "1", "--work-groups", "64x64,2x2", "--size", "64x64")
    by_size = {size_of(result): result for result in results}
    crashed = by_size[64, 64]
    if crashed["invalidity"] == "correct":
        pytest.skip("this driver's stack is large enough")
    assert (crashed["invalidity"], crashed["correctness"]) == ("runtime", 0)
    assert measured(crashed)["detail"].startswith("crashed: signal ")
    assert by_size[2, 2]["invalidity"] == "correct", "the sweep goes on"
    refused = cli("render", deep, "-o", "a.exr", "--samples", "16", "--work-group", "64x64")
    assert refused.returncode == 2
    assert "are safe" in refused.stderr


def test_what_render_refuses_is_marked_and_not_kept(cli: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Eight by four stacks are more than is safe, though fewer than a thread of PoCL has room for."""
    monkeypatch.setenv("FEELER_TUNED", str(tmp_path / "kept.yaml"))
    deep = write_deep_scene(tmp_path / "deep.yaml")
    results = sweep(cli, deep, "--samples", "16", "--repeat", "1", "--work-groups", "8x4", "--size", "8x8", "--save")
    by_size = {size_of(result): result for result in results}
    assert by_size[8, 4]["invalidity"] == "correct"
    assert measured(by_size[8, 4])["forced"] == 1
    assert "work_group: [8, 4]" not in (tmp_path / "kept.yaml").read_text()


def test_a_time_limit_is_a_row(cli: Any, scene: Path) -> None:
    start = time.monotonic()
    results = sweep(cli, scene, "--size", "4096x4096", "--timeout", "0.3", "--work-groups", "4x4", code=1)
    assert time.monotonic() - start < 20
    assert [result["invalidity"] for result in results] == ["timeout", "timeout"]
    assert all(measured(result)["detail"] == "time limit: took more than 0.3 s" for result in results)


@pytest.fixture(scope="module")
def odd_driver(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A library that makes the driver wrong for groups two wide, and its clock for groups sixteen wide."""
    library = tmp_path_factory.mktemp("driver") / "odd_driver.so"
    compiler = shlex.split(os.environ.get("CC", "gcc"))
    source = ROOT / "tests" / "odd_driver.c"
    subprocess.run(
        [*compiler, "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC", "-o", library, source, "-ldl"], check=True
    )
    return library


def test_a_crash_of_the_driver_is_a_row(
    cli: Any, scene: Path, odd_driver: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("LD_PRELOAD", str(odd_driver))
    by_size = {size_of(result): result for result in sweep(cli, scene, *FAST, "--work-groups", "3x1,4x4")}
    assert by_size[3, 1]["invalidity"] == "runtime"
    assert measured(by_size[3, 1])["detail"].startswith("crashed: signal ")
    assert by_size[4, 4]["invalidity"] == "correct", "the sweep goes on"


def test_another_picture_is_a_failure(cli: Any, scene: Path, odd_driver: Path) -> None:
    env = {**os.environ, "LD_PRELOAD": str(odd_driver)}
    done = cli("bench", scene, *FAST, "--work-groups", "2x2,4x4", "--csv", "a.csv", env=env)
    assert done.returncode == 1
    assert "the work group 2x2 makes another picture than the default" in done.stderr
    with (scene.parent / "a.csv").open() as file:
        rows = [(row["work_group_x"], row["invalidity"], row["correctness"]) for row in csv.DictReader(file)]
    assert rows == [("8", "correct", "1"), ("2", "correctness", "0"), ("4", "correct", "1")]


def test_kernels_that_do_not_build(cli: Any, scene: Path) -> None:
    done = cli("bench", scene, *FAST, env={**os.environ, "FEELER_KERNEL_OPTIONS": "-DLANES=nonsense"})
    assert done.returncode == 1
    assert "spheres.nff: the kernels do not build" in done.stderr
    assert done.stdout == ""


def test_an_interruption_ends_the_children(program: Path, tmp_path: Path, scene: Path) -> None:
    command = [program, "bench", scene, "--size", "4096x4096", "--samples", "64", "--json", "a.json"]
    with subprocess.Popen(command, cwd=tmp_path, stderr=subprocess.PIPE, text=True) as process:
        children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
        while not (pids := children.read_text().split()):
            time.sleep(0.05)
        time.sleep(0.5)
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=20)
    assert process.returncode == 130
    assert "interrupted" in errors
    assert not (tmp_path / "a.json").exists()
    assert not [pid for pid in pids if Path(f"/proc/{pid}/cmdline").exists()]


# ---- errors ----

USAGE_ERRORS = {
    "no scene": (["bench"], "SCENE… is missing"),
    "unknown option": (["bench", "spheres.nff", "--work-group", "8x8"], "did you mean '--work-groups'"),
    "a size": (["bench", "spheres.nff", "--work-groups", "8x8,8"], "--work-groups: '8x8,8' is wrong"),
    "nothing between commas": (["bench", "spheres.nff", "--work-groups", "8x8,,4x4"], "commas between them"),
    "a comma at the end": (["bench", "spheres.nff", "--samples", "1,"], "--samples: '1,' is wrong"),
    "samples": (["bench", "spheres.nff", "--samples", "1,0"], "from 1 to 4096"),
    "level": (["bench", "spheres.nff", "--level", "draft,exact"], "draft|standard|reference"),
    "repeat": (["bench", "spheres.nff", "--repeat", "0"], "--repeat: '0'"),
    "timeout": (["bench", "spheres.nff", "--timeout", "0"], "--timeout: '0'"),
    "both to stdout": (["bench", "spheres.nff", "--json", "-", "--csv", "-"], "cannot both be stdout"),
    "a picture too large": (["bench", "spheres.nff", "--size", "65536x65536"], "at most 2^28"),
}


@pytest.mark.parametrize("case", USAGE_ERRORS)
def test_usage_errors(cli: Any, scene: Path, case: str) -> None:
    arguments, text = USAGE_ERRORS[case]
    result = cli(*arguments)
    assert result.returncode == 2, result
    assert text in result.stderr
    assert result.stdout == ""


def test_a_missing_scene_does_not_stop_the_others(cli: Any, scene: Path) -> None:
    result = cli("bench", "missing.yaml", scene, *FAST, "--repeat", "1")
    assert result.returncode == 1
    assert re.match(r"feeler: missing\.yaml.*: ", result.stderr)
    assert "* 8x8" in result.stdout


def test_a_missing_device(cli: Any, scene: Path) -> None:
    result = cli("bench", scene, *FAST, "--device", "no such device")
    assert result.returncode == 1
    assert "spheres.nff: no OpenCL device" in result.stderr
    assert result.stdout == ""


@pytest.mark.parametrize("option", ["--json", "--csv"])
def test_a_missing_folder_is_told_before(cli: Any, scene: Path, option: str) -> None:
    result = cli("bench", scene, option, "none/a")
    assert result.returncode == 1
    assert "none/a" in result.stderr
    assert result.stdout == ""


# ---- keeping ----


@pytest.fixture
def config(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    return tmp_path / "config" / "feeler" / "work-groups.yaml"


def test_save_and_render(cli: Any, scene: Path, config: Path) -> None:
    done = cli("bench", scene, *FAST, "--save")
    assert done.returncode == 0, done.stderr
    kept = re.search(r"kept in (.*): (\d+)x(\d+) for kernels like", done.stderr)
    assert kept and kept[1] == str(config)
    best = re.search(r"best: (\d+)x(\d+)", done.stdout)
    assert kept.groups()[1:] == (best.groups() if best else ("8", "8"))
    stats = feeler.load(scene).render().stats
    assert stats["work_group"] == [int(kept[2]), int(kept[3])]
    assert stats["work_group_from"] == "tuned"
    info = json.loads(cli("info", scene, "--json").stdout)
    assert info["tuned"]["work_groups"] == {stats["device"]: stats["work_group"]}


def test_a_size_that_is_surely_faster(cli: Any, scene: Path, config: Path, odd_driver: Path) -> None:
    done = cli("bench", scene, *FAST, "--save", env={**os.environ, "LD_PRELOAD": str(odd_driver)})
    assert "best: 16x4\n" in done.stdout
    assert "2x2 makes another picture" in done.stderr
    assert feeler.load(scene).render().stats["work_group"] == [16, 4]


def test_the_best_is_kept_for_scenes_that_are_alike(cli: Any, tmp_path: Path, scene: Path, config: Path) -> None:
    write_spheres(tmp_path / "other.nff", (40, 30))
    (tmp_path / "plain.nff").write_text(scene.read_text().replace("20 0 1", "20 0.5 1.5"))  # it transmits
    done = cli("bench", scene, "other.nff", "plain.nff", *FAST, "--repeat", "1", "--save")
    assert done.returncode == 0, done.stderr
    assert done.stderr.count("kept in") == 2
    assert config.read_text().count("work_group: ") == 2


def test_save_leaves_a_damaged_file_alone(cli: Any, scene: Path, config: Path) -> None:
    config.parent.mkdir(parents=True)
    config.write_text("work_groups:\n- 5\n")
    done = cli("bench", scene, *FAST, "--save")
    assert done.returncode == 1
    assert f"{config}:2:3: " in done.stderr
    assert done.stdout == "", "told before any time is spent"
    assert config.read_text() == "work_groups:\n- 5\n"


def test_save_without_a_file(cli: Any, scene: Path) -> None:
    done = cli("bench", scene, *FAST, "--save", env={**os.environ, "FEELER_TUNED": ""})
    assert done.returncode == 1
    assert "FEELER_TUNED is empty" in done.stderr
    assert done.stdout == ""
