"""The program as its users meet it: help, exit codes, names, files, devices."""

from __future__ import annotations

import json
import os
import re
import stat
import subprocess
from pathlib import Path
from typing import Any

import pytest
from places import ROOT
from spheres import write_spheres

COMMANDS = ["render", "info", "pixel", "compare", "bench", "chart", "devices", "doctor"]


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    return write_spheres(tmp_path / "spheres.nff")


def leftovers(folder: Path) -> list[str]:
    return [p.name for p in folder.iterdir() if p.name.startswith(".")]


# ---- help and usage ----


def test_help_and_version(cli: Any) -> None:
    result = cli("--help")
    assert result.returncode == 0
    assert result.stderr == ""
    assert all(command in result.stdout for command in COMMANDS)
    result = cli("--version")
    assert result.returncode == 0
    assert re.fullmatch(r"feeler \d+\.\d+\.\d+\n", result.stdout)


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.parametrize("flag", ["--help", "-h"])
def test_help_of_each_command(cli: Any, command: str, flag: str) -> None:
    result = cli(command, flag)
    assert result.returncode == 0
    assert result.stderr == ""
    assert result.stdout.startswith(f"Usage: feeler {command}")
    assert "--help" in result.stdout


def test_render_help_names_every_option(cli: Any) -> None:
    text = cli("render", "--help").stdout
    for option in [
        "out",
        "size",
        "samples",
        "jitter",
        "depth",
        "cutoff",
        "level",
        "region",
        "alpha",
        "bits",
        "device",
        "work-group",
        "stats",
        "quiet",
    ]:
        assert re.search(rf"--{option}\b", text), option
    assert "default: " in text


def section_of(page: str, command: str) -> str:
    """What a manual has about a command's options."""
    heading = rf"## feeler {command}\n" if page.endswith(".md") else rf"\.SH OPTIONS OF {command.upper()}\n"
    text = (ROOT / "docs" / page).read_text().replace("\\-", "-")
    (section,) = re.findall(rf"^{heading}(.*?)^(?:## |\.SH )", text, re.MULTILINE | re.DOTALL)
    return str(section)


@pytest.mark.parametrize("page", ["command-line.md", "feeler.1"])
def test_pages_name_every_option(cli: Any, page: str) -> None:
    for command in COMMANDS:
        options = re.findall(r"^  (?:-\w, |    )--(\S+)", cli(command, "--help").stdout, re.MULTILINE)
        assert options.pop() == "help"
        for option in options:
            assert f"--{option}" in section_of(page, command), (command, option)


def test_defaults_in_the_document_are_those_of_the_help(cli: Any) -> None:
    compared = 0
    for command in COMMANDS:
        said = cli(command, "--help").stdout
        for line in section_of("command-line.md", command).splitlines():
            cells = [cell.strip().replace("`", "") for cell in line.split("|")[1:-1]]
            option = re.fullmatch(r"(?:-\w, )?--([a-z]\S*)", cells[0]) if cells else None
            if not option:
                continue
            (row,) = re.findall(rf"^  (?:-\w, |    )--{option[1]}\b(?:.*\n {{26}})?.*$", said, re.MULTILINE)
            told = re.search(r"\(default: (?:the )?(.*)\)$", row)
            compared += told is not None
            assert cells[2].removeprefix("the ").startswith(told[1] if told else ("off", "none", "required")), row
    assert compared > 25


USAGE_ERRORS = {
    "no command": ([], "command is missing"),
    "unknown command": (["rendr"], "did you mean 'render'"),
    "no scene": (["render", "-o", "a.png"], "SCENE… is missing"),
    "no output": (["render", "spheres.nff"], "--out is missing"),
    "unknown option": (["render", "spheres.nff", "-o", "a.png", "--sampels", "3"], "did you mean '--samples'"),
    "unknown letter": (["render", "spheres.nff", "-z"], "unknown option '-z'"),
    "unknown digit": (["render", "spheres.nff", "-o", "a.png", "-4"], "unknown option '-4'"),
    "no value": (["render", "spheres.nff", "-o"], "--out needs a value"),
    "flag with value": (["render", "spheres.nff", "--alpha=1", "-o", "a.png"], "--alpha takes no value"),
    "size": (["render", "spheres.nff", "-o", "a.png", "--size", "64"], "--size: '64'"),
    "size 0": (["render", "spheres.nff", "-o", "a.png", "--size=0x48"], "--size: '0x48'"),
    "size tail": (["render", "spheres.nff", "-o", "a.png", "--size=64x48x"], "--size: '64x48x'"),
    "samples": (["render", "spheres.nff", "-o", "a.png", "--samples", "1.5"], "--samples: '1.5'"),
    "samples 0": (["render", "spheres.nff", "-o", "a.png", "--samples", "0"], "--samples: '0'"),
    "samples huge": (["render", "spheres.nff", "-o", "a.png", "--samples", "99999999999999"], "--samples: "),
    "jitter": (["render", "spheres.nff", "-o", "a.png", "--jitter", "1.1"], "from 0 to 1"),
    "jitter nan": (["render", "spheres.nff", "-o", "a.png", "--jitter", "nan"], "--jitter: 'nan'"),
    "jitter 1.5x": (["render", "spheres.nff", "-o", "a.png", "--jitter", "0.5x"], "--jitter: '0.5x'"),
    "cutoff 1e400": (["render", "spheres.nff", "-o", "a.png", "--cutoff", "1e400"], "--cutoff: '1e400'"),
    "level": (["render", "spheres.nff", "-o", "a.png", "--level", "exact"], "draft|standard|reference"),
    "bits": (["render", "spheres.nff", "-o", "a.png", "--bits", "12"], "8|16"),
    "region empty": (["render", "spheres.nff", "-o", "a.png", "--region", "5,5,5,9"], "X0 < X1"),
    "region outside": (["render", "spheres.nff", "-o", "a.png", "--region", "5,5,65,9"], "region"),
    "ending": (["render", "spheres.nff", "-o", "a.xyz"], "unknown picture format '.xyz'"),
    "no ending": (["render", "spheres.nff", "-o", "a"], "no ending"),
    "jpg alpha": (["render", "spheres.nff", "-o", "a.jpg", "--alpha"], "no alpha"),
    "hdr alpha": (["render", "spheres.nff", "-o", "a.hdr", "--alpha"], "no alpha"),
    "jpg bits": (["render", "spheres.nff", "-o", "a.jpg", "--bits", "16"], "16 bits"),
    "exr bits": (["render", "spheres.nff", "-o", "a.exr", "--bits", "16"], "16 bits"),
    "several, one name": (["render", "spheres.nff", "b.nff", "-o", "a.png"], "must contain {name}"),
    "several, one stats": (
        ["render", "spheres.nff", "b.nff", "-o", "{name}.png", "--stats", "s.json"],
        "--stats: with several",
    ),
    "one file for two": (["render", "spheres.nff", "-o", "a.png", "--stats", "a.png"], "cannot both be a.png"),
    "same names": (["render", "x/a.nff", "y/a.nff", "-o", "{name}.png"], "same name"),
    "chart of nothing": (["chart", "--quick"], "SCENE… is missing"),
    "chart samples": (["chart", "spheres.nff", "--truth-samples", "1"], "a whole number from 2 to 4096"),
    "info of two": (["info", "a.nff", "b.nff"], "'b.nff' is too much"),
    "devices operand": (["devices", "x"], "only options"),
}


@pytest.mark.parametrize("case", USAGE_ERRORS)
def test_usage_errors(cli: Any, tmp_path: Path, scene: Path, case: str) -> None:
    arguments, text = USAGE_ERRORS[case]
    result = cli(*arguments)
    assert result.returncode == 2, result
    assert result.stderr.startswith("feeler: ")
    assert text in result.stderr
    assert result.stdout == ""
    assert list(tmp_path.iterdir()) == [scene]


# ---- what cannot be read or written ----


def test_missing_scene(cli: Any, tmp_path: Path) -> None:
    result = cli("render", "missing.yaml", "-o", "a.png")
    assert result.returncode == 1
    assert re.match(r"feeler: missing\.yaml.*: ", result.stderr)
    assert not list(tmp_path.iterdir())


def test_output_is_a_folder(cli: Any, tmp_path: Path, scene: Path) -> None:
    (tmp_path / "a.png").mkdir()
    result = cli("render", scene, "-o", "a.png")
    assert result.returncode == 1
    assert "is a folder" in result.stderr


def test_folder_is_missing(cli: Any, scene: Path) -> None:
    result = cli("render", scene, "-o", "none/a.png")
    assert result.returncode == 1
    assert "'none'" in result.stderr


@pytest.mark.parametrize("command", [["render", "-o", "a.png", "--stats"], ["bench", "--csv"], ["bench", "--json"]])
def test_the_scene_is_no_output(cli: Any, tmp_path: Path, scene: Path, command: list[str]) -> None:
    text = scene.read_text()
    result = cli(*command, f"./{scene.name}", scene)
    assert result.returncode == 1
    assert f"./{scene.name}: is the scene, which would be lost\n" in result.stderr
    assert scene.read_text() == text
    assert list(tmp_path.iterdir()) == [scene]


def test_stats_folder_is_missing(cli: Any, tmp_path: Path, scene: Path) -> None:
    result = cli("render", scene, "-o", "a.png", "--stats", "none/a.json")
    assert result.returncode == 1
    assert "none/a.json" in result.stderr
    assert not (tmp_path / "a.png").exists()


def test_output_is_not_a_regular_file(cli: Any, tmp_path: Path, scene: Path) -> None:
    os.mkfifo(tmp_path / "a.png")
    result = cli("render", scene, "-o", "a.png")
    assert result.returncode == 1
    assert "not a regular file" in result.stderr


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_folder_is_read_only(cli: Any, tmp_path: Path, scene: Path) -> None:
    (tmp_path / "closed").mkdir(mode=0o500)
    result = cli("render", scene, "-o", "closed/a.png")
    assert result.returncode == 1
    assert "closed" in result.stderr


def test_a_full_disk_leaves_nothing_behind(program: Path, tmp_path: Path, scene: Path) -> None:
    (tmp_path / "a.exr").write_text("old")
    # Files may not grow beyond 2 MiB: enough for a kernel, not for this picture.
    command: list[str | Path] = [
        "bash",
        "-c",
        "ulimit -f 2048; trap '' XFSZ; exec \"$@\"",
        "bash",
        program,
        "render",
        scene,
        "-o",
        "a.exr",
    ]
    result = subprocess.run(
        [*command, "--size", "1600x1200"], cwd=tmp_path, capture_output=True, text=True, check=False, timeout=300
    )
    assert result.returncode == 1
    assert "feeler: a.exr: cannot write" in result.stderr
    assert (tmp_path / "a.exr").read_text() == "old"
    assert not leftovers(tmp_path)


# ---- devices ----


def test_devices(cli: Any) -> None:
    listing = json.loads(cli("devices", "--json").stdout)
    devices = [device for platform in listing["platforms"] for device in platform["devices"]]
    assert [device["index"] for device in devices] == list(range(len(devices)))
    assert sum(device["default"] for device in devices) == 1
    text = cli("devices").stdout
    assert all(device["name"] in text for device in devices)


@pytest.mark.parametrize("select", ["no such device", "99", "99999999999999999999999"])
def test_unknown_device(cli: Any, tmp_path: Path, scene: Path, select: str) -> None:
    result = cli("render", scene, "-o", "a.png", "--device", select)
    assert result.returncode == 1
    assert "no OpenCL device" in result.stderr
    assert not (tmp_path / "a.png").exists()


@pytest.mark.parametrize("select", ["0", "portable COMPUTING"])
def test_device_by_number_and_name(cli: Any, tmp_path: Path, scene: Path, select: str) -> None:
    result = cli("render", scene, "-o", "a.png", "--device", select)
    assert result.returncode == 0, result.stderr


def test_no_platform(cli: Any, tmp_path: Path, scene: Path) -> None:
    empty = tmp_path / "vendors"
    empty.mkdir()
    env = {**os.environ, "OCL_ICD_VENDORS": str(empty) + "/"}
    result = cli("render", scene, "-o", "a.png", env=env)
    assert result.returncode == 1
    assert "no OpenCL platform" in result.stderr
    assert "pocl-opencl-icd" in result.stderr
    result = cli("doctor", env=env)
    assert result.returncode == 1
    assert "FAIL" in result.stdout
    assert "to mend: apt install" in result.stdout


def test_doctor(cli: Any) -> None:
    result = cli("doctor")
    assert result.returncode == 0, result.stdout
    for text in [
        "version",
        "ICD loader",
        "kernel cache",
        "OpenImageIO   writes exr, hdr, png, tif, jpg",
        "square root",
    ]:
        assert text in result.stdout


def test_doctor_waits_for_what_is_compiled_at_the_first_launch(cli: Any, tmp_path: Path) -> None:
    result = cli("doctor", env={**os.environ, "POCL_CACHE_DIR": str(tmp_path / "cache")})
    assert result.returncode == 0, result.stdout


def test_doctor_finds_a_closed_cache(cli: Any, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    result = cli("doctor", env={**os.environ, "POCL_CACHE_DIR": str(tmp_path / "file" / "cache")})
    assert result.returncode == 1
    assert "POCL_CACHE_DIR" in result.stdout


# ---- info ----


def test_info(cli: Any, scene: Path) -> None:
    result = cli("info", scene, "--json")
    assert result.returncode == 0, result.stderr
    information = json.loads(result.stdout)
    text = cli("info", scene).stdout
    for key in information:
        assert key.replace("_", " ") in text


# ---- files ----


def test_nothing_else_is_left(cli: Any, tmp_path: Path, scene: Path) -> None:
    assert cli("render", scene, "-o", "a.png", "--stats", "a.json").returncode == 0
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.json", "a.png", "spheres.nff"]


def test_modes_and_links(cli: Any, tmp_path: Path, scene: Path) -> None:
    (tmp_path / "old.png").write_text("old")
    (tmp_path / "old.png").chmod(0o640)
    (tmp_path / "link.png").symlink_to("old.png")
    assert cli("render", scene, "-o", "link.png", "--quiet", umask=0o022).returncode == 0
    assert cli("render", scene, "-o", "new.png", "--quiet", umask=0o027).returncode == 0
    assert (tmp_path / "link.png").is_symlink()
    assert (tmp_path / "old.png").read_bytes().startswith(b"\x89PNG")
    assert stat.S_IMODE((tmp_path / "old.png").stat().st_mode) == 0o640
    assert stat.S_IMODE((tmp_path / "new.png").stat().st_mode) == 0o640


def test_a_failure_leaves_the_old_file(cli: Any, tmp_path: Path, scene: Path) -> None:
    (tmp_path / "a.png").write_text("old")
    assert cli("render", "missing.nff", "-o", "a.png").returncode == 1
    assert (tmp_path / "a.png").read_text() == "old"


def test_several_scenes(cli: Any, tmp_path: Path, scene: Path) -> None:
    write_spheres(tmp_path / "other.nff", (32, 24))
    (tmp_path / "broken.nff").write_text("v\nfrom 0 0\n")
    result = cli("render", scene, "broken.nff", "other.nff", "-o", "{name}.exr", "--stats", "{name}.json")
    assert result.returncode == 1
    assert "broken.nff" in result.stderr
    for name, size in [("spheres", [64, 48]), ("other", [32, 24])]:
        assert (tmp_path / f"{name}.exr").exists()
        assert json.loads((tmp_path / f"{name}.json").read_text())["size"] == size
    assert not (tmp_path / "broken.exr").exists()


def test_names_that_look_like_options(cli: Any, tmp_path: Path) -> None:
    write_spheres(tmp_path / "-s.nff")
    assert cli("render", "-oa.png", "-q", "--", "-s.nff").returncode == 0
    assert (tmp_path / "a.png").exists()


def test_full_standard_output_is_a_failure(cli: Any) -> None:
    with Path("/dev/full").open("w") as full:
        result = cli("devices", capture_output=False, stdout=full, stderr=subprocess.PIPE)
    assert result.returncode == 1
    assert "standard output" in result.stderr
