"""The user's file of work groups: who uses it, what is told of it, what happens when it is damaged."""

from __future__ import annotations

import json
import os
import warnings
from pathlib import Path
from typing import Any

import pytest
from pictures import same_bits
from spheres import write_spheres

import feeler
from feeler._library import call, ffi, lib

HEADER = "work_groups:\n"
ENTRY = """\
- device: "{device}"
  options: "{options}"
  work_group: [{x}, {y}]
"""


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    return write_spheres(tmp_path / "spheres.nff")


@pytest.fixture
def tuned(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The file, in a folder that is not there yet."""
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "config"))
    return tmp_path / "config" / "feeler" / "work-groups.yaml"


def keep(stats: dict[str, Any]) -> None:
    call(lib.feeler_tuned_keep, json.dumps(stats).encode())


def write(path: Path, stats: dict[str, Any], *, x: int = 16, y: int = 4, **other: Any) -> None:
    """An entry for the kernel of a render, but for what is given."""
    entry = {**stats, "x": x, "y": y, **other}
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(HEADER + ENTRY.format(**entry))


def test_kept_and_used(cli: Any, scene: Path, tuned: Path) -> None:
    """C, the program and Python are one: what one keeps the others use, and the picture stays the same."""
    loaded = feeler.load(scene)
    before = loaded.render()
    assert before.stats["work_group_from"] == "chosen"
    keep(loaded.render(work_group=(5, 3)).stats)
    after = loaded.render()
    assert (after.stats["work_group"], after.stats["work_group_from"]) == ([5, 3], "tuned")
    assert same_bits(after.pixels, before.pixels)
    result = cli("render", scene, "-o", "a.exr", "--stats", "a.json")
    assert result.returncode == 0
    assert "work group 5x3 (tuned)" in result.stderr
    stats = json.loads((scene.parent / "a.json").read_text())
    assert (stats["work_group"], stats["work_group_from"]) == ([5, 3], "tuned")
    result = cli("render", scene, "-o", "a.exr", "--work-group", "2x2")
    assert "work group 2x2 (given)" in result.stderr
    assert "tuned" not in result.stderr


def test_info_says_so(cli: Any, scene: Path, tuned: Path) -> None:
    assert json.loads(cli("info", scene, "--json").stdout)["tuned"] == {}
    stats = feeler.load(scene).render(work_group=(5, 3)).stats
    keep(stats)
    expected = {"file": str(tuned), "work_groups": {stats["device"]: [5, 3]}}
    assert json.loads(cli("info", scene, "--json").stdout)["tuned"] == expected
    assert feeler.load(scene).info()["tuned"] == expected
    assert json.loads(cli("info", scene, "--json", "--level", "draft").stdout)["tuned"] == {}
    assert str(tuned) in cli("info", scene).stdout


@pytest.mark.parametrize("other", [{"level": "draft"}, {"lanes": 2}, {"general": True}, {"brute_force": True}])
def test_only_for_its_kernel(scene: Path, tuned: Path, other: dict[str, Any]) -> None:
    """Settings that change the kernel have sizes of their own; others, such as the picture's size, have not."""
    loaded = feeler.load(scene)
    keep(loaded.render(work_group=(16, 4)).stats)
    assert loaded.render(size=(20, 30)).stats["work_group"] == [16, 4]
    assert loaded.render(**other).stats["work_group_from"] == "chosen"


def test_only_for_its_device(scene: Path, tuned: Path) -> None:
    loaded = feeler.load(scene)
    stats = loaded.render().stats
    write(tuned, stats)
    assert loaded.render().stats["work_group"] == [16, 4]
    write(tuned, stats, device="another")
    assert loaded.render().stats["work_group_from"] == "chosen"


def test_a_size_that_is_too_large_is_left_alone(scene: Path, tuned: Path) -> None:
    loaded = feeler.load(scene)
    write(tuned, loaded.render().stats, x=60000, y=60000)
    assert loaded.render().stats["work_group_from"] == "chosen"


def test_keeping_replaces_only_its_own(scene: Path, tuned: Path) -> None:
    loaded = feeler.load(scene)
    for level in ("standard", "draft"):
        keep(loaded.render(work_group=(4, 4), level=level).stats)
    keep(loaded.render(work_group=(2, 8)).stats)
    assert loaded.render().stats["work_group"] == [2, 8]
    assert loaded.render(level="draft").stats["work_group"] == [4, 4]
    assert [path.name for path in tuned.parent.iterdir()] == [tuned.name]


def test_strange_device_names_come_back(scene: Path, tuned: Path) -> None:
    stats = feeler.load(scene).render().stats
    keep({**stats, "device": 'a "quoted" \\ name: # \t é'})
    text = feeler.load(scene).info()["tuned"]
    assert list(text["work_groups"]) == ['a "quoted" \\ name: # \t é']


@pytest.mark.parametrize("stats", ["", "{}", "[]", '{"device": "x", "options": 1, "work_group": [1, 1]}'])
def test_only_statistics_are_kept(tuned: Path, stats: str) -> None:
    with pytest.raises(feeler.Error, match="not the statistics"):
        call(lib.feeler_tuned_keep, stats.encode())
    assert not tuned.exists()


def test_the_environment_chooses_or_forbids(
    cli: Any, tmp_path: Path, scene: Path, tuned: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    loaded = feeler.load(scene)
    keep(loaded.render(work_group=(5, 3)).stats)
    monkeypatch.setenv("FEELER_TUNED", "")
    stats = loaded.render(work_group=(7, 1)).stats
    assert loaded.render().stats["work_group_from"] == "chosen"
    assert lib.feeler_tuned_path() == ffi.NULL
    with pytest.raises(feeler.Error, match="FEELER_TUNED is empty"):
        keep(stats)
    monkeypatch.setenv("FEELER_TUNED", str(tmp_path / "own.yaml"))
    keep(stats)
    assert loaded.render().stats["work_group"] == [7, 1]
    assert "work group 7x1 (tuned)" in cli("render", scene, "-o", "a.exr").stderr


@pytest.mark.parametrize("config", [None, "", "relative"])
def test_without_a_folder_of_configuration(
    tmp_path: Path, scene: Path, config: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.delenv("XDG_CONFIG_HOME")
    if config is not None:
        monkeypatch.setenv("XDG_CONFIG_HOME", config)
    keep(feeler.load(scene).render().stats)
    assert (tmp_path / ".config" / "feeler" / "work-groups.yaml").is_file()


DAMAGED = {
    "no YAML": ("work_groups: [", 1),
    "a list": ("- 1\n", 1),
    "an unknown key": ("work_groups: []\nwork_grups: 1\n", 2),
    "no list": ("work_groups: 3\n", 1),
    "no entry": (HEADER + "- 5\n", 2),
    "no device": (HEADER + ENTRY.format(device="", options="x", x=1, y=1), 2),
    "no options": (HEADER + ENTRY.format(device="d", options="", x=1, y=1), 3),
    "size 0": (HEADER + ENTRY.format(device="d", options="x", x=0, y=1), 4),
    "half a size": (HEADER + ENTRY.format(device="d", options="x", x=1.5, y=1), 4),
    "size of three": (HEADER + ENTRY.format(device="d", options="x", x="1, 1", y=1), 4),
    "half an entry": (HEADER + "- device: d\n", 2),
}


@pytest.mark.parametrize("case", DAMAGED)
def test_a_damaged_file_is_a_warning(scene: Path, tuned: Path, case: str) -> None:
    text, line = DAMAGED[case]
    tuned.parent.mkdir(parents=True)
    tuned.write_text(text)
    loaded = feeler.load(scene)
    with pytest.warns(RuntimeWarning, match=rf"work-groups\.yaml:{line}:\d+: .*not used"):
        assert loaded.render().stats["work_group_from"] == "chosen"
    with pytest.raises(feeler.Error) as caught:
        keep(loaded.render(work_group=(2, 2)).stats)
    assert caught.value.line == line
    assert tuned.read_text() == text, "what a user wrote is not thrown away"


def test_the_program_warns_too(cli: Any, scene: Path, tuned: Path) -> None:
    tuned.parent.mkdir(parents=True)
    tuned.write_text("work_groups:\n- 5\n")
    for command in (["render", scene, "-o", "a.exr", "-q"], ["info", scene]):
        result = cli(*command)
        assert result.returncode == 0
        assert f"feeler: warning: {tuned}:2:3: " in result.stderr
    assert "warning" not in cli("render", scene, "-o", "a.exr", "-q", "--work-group", "2x2").stderr


def test_an_unreadable_file_is_a_warning(scene: Path, tuned: Path) -> None:
    tuned.mkdir(parents=True)  # a folder in its place, since root may read every file
    with pytest.warns(RuntimeWarning, match="work-groups"):
        feeler.load(scene).render()


def test_no_file_is_nothing_to_tell(scene: Path, tuned: Path) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        feeler.load(scene).render()
    assert not tuned.parent.exists()


def test_a_link_stays_one(tmp_path: Path, scene: Path, tuned: Path) -> None:
    (tmp_path / "real.yaml").write_text("work_groups: []\n")
    (tmp_path / "real.yaml").chmod(0o640)
    tuned.parent.mkdir(parents=True)
    tuned.symlink_to(tmp_path / "real.yaml")
    keep(feeler.load(scene).render(work_group=(2, 2)).stats)
    assert tuned.is_symlink()
    assert "work_group: [2, 2]" in (tmp_path / "real.yaml").read_text()
    assert (tmp_path / "real.yaml").stat().st_mode & 0o777 == 0o640


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_folder_that_cannot_be_made(tmp_path: Path, scene: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "closed").mkdir(mode=0o500)
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "closed"))
    with pytest.raises(feeler.Error, match="cannot make the folder"):
        keep(feeler.load(scene).render().stats)
