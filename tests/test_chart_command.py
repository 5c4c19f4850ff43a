"""`feeler chart`: which Python it runs, what it asks for, and what it writes and says."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import pytest
from measured import made_up, made_up_pairs
from spheres import write_spheres

from feeler import accuracy, specialisation, sweep

command = pytest.importorskip("feeler._chart", reason="needs matplotlib")

FILES = [".csv", ".json", ".png", ".svg"]


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    return write_spheres(tmp_path / "spheres.nff")


def script(path: Path, text: str) -> dict[str, str]:
    """An environment in which this shell script is the Python that `feeler chart` runs."""
    path.write_text(f"#!/bin/sh\n{text}\n")
    path.chmod(0o755)
    return {**os.environ, "FEELER_PYTHON": str(path)}


# ---- the program ----


def test_the_request(cli: Any, tmp_path: Path) -> None:
    """The last argument; what is not given is not there."""
    environment = script(tmp_path / "python", 'shift 2; printf "%s" "$1"')
    done = cli("chart", "b c.nff", "ä.yaml", env=environment)
    assert (done.returncode, done.stderr) == (0, "")
    given = {"specialised": False, "quick": False, "quiet": False}
    assert json.loads(done.stdout) == {"scenes": ["b c.nff", "ä.yaml"], **given}
    options = ["--size=32x24", "--repeat", 2, "--truth-samples", 9, "--quick", "-q", "-o", "x/{name}", "--device", "0"]
    done = cli("chart", *options, "a.nff", env=environment)
    assert json.loads(done.stdout) == {
        "scenes": ["a.nff"], **given, "quick": True, "quiet": True, "size": [32, 24], "repeat": 2, "truth_samples": 9,
        "out": "x/{name}", "device": "0",
    }  # fmt: skip
    assert command.Request(**json.loads(done.stdout)).plan() == sweep.Plan(
        size=(32, 24), repeat=2, truth_samples=9, samples=sweep.QUICK.samples
    )


def test_its_exit_code_is_python_s(cli: Any, tmp_path: Path) -> None:
    assert cli("chart", "a.nff", env=script(tmp_path / "python", "exit 7")).returncode == 7


def test_no_python(cli: Any, tmp_path: Path) -> None:
    done = cli("chart", "a.nff", env={**os.environ, "FEELER_PYTHON": str(tmp_path / "none")})
    assert done.returncode == 1
    assert done.stderr == (
        f"feeler: chart: cannot run '{tmp_path}/none': No such file or directory; FEELER_PYTHON can name another Python\n"
    )


def test_a_python_without_the_package(cli: Any, program: Path, tmp_path: Path) -> None:
    python = program.parent.parent / ".venv" / "bin" / "python"
    done = cli("chart", "a.nff", env=script(tmp_path / "python", f'exec "{python}" -I -S "$@"'))
    assert done.returncode == 1
    assert "cannot load the Python package feeler with its charts (No module named 'feeler')" in done.stderr
    assert done.stderr.count("\n") == 1


def test_a_python_without_matplotlib(cli: Any, program: Path, tmp_path: Path) -> None:
    """It is told before anything is measured. Modules of the working folder do not count."""
    (tmp_path / "json.py").write_text("raise SystemExit('from the working folder')")
    (tmp_path / "hides").mkdir()
    (tmp_path / "hides" / "matplotlib.py").write_text("raise ImportError('hidden')")
    done = cli("chart", "a.nff", env={**os.environ, "PYTHONPATH": str(tmp_path / "hides")})
    assert done.returncode == 1
    assert "feeler.charts needs matplotlib: pip install 'feeler[charts]'" in done.stderr
    assert done.stderr.count("\n") == 1


def test_the_checkout_s_python_is_the_default(cli: Any, tmp_path: Path) -> None:
    """And a scene that is not there is told."""
    environment = {name: value for name, value in os.environ.items() if name != "FEELER_PYTHON"}
    done = cli("chart", "missing.nff", env=environment)
    assert done.returncode == 1
    assert done.stderr.startswith("feeler: missing.nff: ")
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_a_whole_run(cli: Any, tmp_path: Path, scene: Path) -> None:
    done = cli("chart", scene, "--quick", "--size", "16x12", "--repeat", 1, "--truth-samples", 5, timeout=900)
    assert (done.returncode, done.stderr) == (0, "")
    assert sorted(path.name for path in tmp_path.glob("accuracy*")) == [f"accuracy-spheres{end}" for end in FILES]
    results = accuracy.read(tmp_path / "accuracy-spheres.json")
    assert {point.setting.level for point in results.points} == {"draft", "standard", "reference"}
    assert {point.setting.factor for point in results.points} == {"level", "depth", "cutoff", "method"}
    done = cli("chart", scene, "--specialised", "--size", "16x12", "--repeat", 1, timeout=900)
    assert (done.returncode, done.stderr) == (0, "")
    assert sorted(path.name for path in tmp_path.glob("specialised*")) == [f"specialised{end}" for end in FILES]


# ---- what it runs ----


@pytest.fixture
def nothing_measured(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> list[Any]:
    """Results are made up; the list is of what was asked for."""
    asked: list[Any] = []

    def sweep_(_scene: Any, plan: Any, **_other: Any) -> accuracy.Accuracy:
        asked.append(plan)
        return made_up()

    def pairs(path: str, **settings: Any) -> specialisation.Specialisation:
        asked.append((Path(path).name, settings["size"], settings["repeat"]))
        return made_up_pairs()[len(asked) % 2]

    def draw(_results: Any, *, save: str) -> None:
        for ending in (".png", ".svg"):
            Path(save.removesuffix(".png") + ending).touch()

    monkeypatch.setattr(command.charts, "accuracy", draw)
    monkeypatch.setattr(command.charts, "specialisation", draw)
    monkeypatch.setattr(sweep, "measure", sweep_)
    monkeypatch.setattr(specialisation, "measure", pairs)
    monkeypatch.chdir(tmp_path)
    return asked


def run(*scenes: Path | str, **options: Any) -> int:
    return int(command.main(json.dumps({"scenes": [str(path) for path in scenes], **options})))


def test_what_is_written_and_said(nothing_measured: Any, scene: Path, tmp_path: Path, capsys: Any) -> None:
    assert run(scene) == 0
    assert sorted(path.name for path in tmp_path.glob("accuracy*")) == [f"accuracy-spheres{end}" for end in FILES]
    assert accuracy.read(tmp_path / "accuracy-spheres.json") == made_up()
    said = capsys.readouterr().out.splitlines()
    assert said[2].split()[:5] == ["F", "draft", "1", "1.90", "1.85"], "the fastest first"
    assert next(line.split()[:3] for line in said if line.startswith("*")) == ["*F", "standard", "16"]
    assert "left out: 1 lane, too slow" in said
    assert nothing_measured == [sweep.Plan()]


def test_quiet(nothing_measured: Any, scene: Path, capsys: Any) -> None:
    assert run(scene, quiet=True, quick=True) == 0
    assert capsys.readouterr().out == ""
    assert nothing_measured == [sweep.QUICK]


@pytest.mark.parametrize(
    ("out", "expected"),
    [("x.svg", "x"), ("x.v1", "x.v1"), ("folder", "folder/accuracy-spheres"), ("{name}-a", "spheres-a")],
)
def test_names(nothing_measured: Any, scene: Path, tmp_path: Path, out: str, expected: str) -> None:
    (tmp_path / "folder").mkdir()
    assert run(scene, out=out) == 0
    assert all((tmp_path / f"{expected}{ending}").is_file() for ending in FILES)


def test_several_scenes(nothing_measured: Any, scene: Path, tmp_path: Path, capsys: Any) -> None:
    other = write_spheres(tmp_path / "others.nff")
    assert run(scene, other, out="x-{name}") == 0
    assert (tmp_path / "x-spheres.png").is_file()
    assert (tmp_path / "x-others.png").is_file()
    assert run(scene, other, out="x.png") == 2
    assert "--out must contain {name}" in capsys.readouterr().err
    assert run(scene, scene) == 2
    assert len(nothing_measured) == 2


def test_specialised(nothing_measured: Any, scene: Path, tmp_path: Path, capsys: Any) -> None:
    other = write_spheres(tmp_path / "others.nff")
    assert run(scene, other, specialised=True, size=[32, 24]) == 0
    assert nothing_measured == [("spheres.nff", (32, 24), 3), ("others.nff", (32, 24), 3)]
    assert len(specialisation.read(tmp_path / "specialised.json")) == 2
    assert "balls: trace 0.020 → 0.010 s, 0.50; compile 4.000 → 2.000 s, 0.50 of the time" in capsys.readouterr().out


def test_failures(nothing_measured: Any, scene: Path, tmp_path: Path, capsys: Any) -> None:
    """Before anything is measured."""
    assert run(scene, out="none/x") == 1
    why = "cannot write into the folder 'none': No such file or directory"
    assert capsys.readouterr().err == f"feeler: none/x: {why}\n"
    assert run(scene, out=f"{scene.name}/") == 1
    assert f"cannot write into the folder '{scene.name}': Not a directory\n" in capsys.readouterr().err
    assert run(scene, "missing.nff") == 1
    assert run(scene, "missing.nff", specialised=True) == 1
    assert nothing_measured == []
    (tmp_path / "a.json").mkdir()
    assert run(scene, out="a") == 1
    assert capsys.readouterr().err.endswith("feeler: a.json: Is a directory\n")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may write everywhere")
def test_a_folder_that_is_read_only(nothing_measured: Any, scene: Path, tmp_path: Path, capsys: Any) -> None:
    (tmp_path / "closed").mkdir(mode=0o500)
    assert run(scene, out="closed") == 1
    assert capsys.readouterr().err.endswith("cannot write into the folder 'closed': Permission denied\n")
    assert nothing_measured == []


def test_an_interruption(monkeypatch: pytest.MonkeyPatch, scene: Path, tmp_path: Path, capsys: Any) -> None:
    def stop(*_: Any, **__: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sweep, "measure", stop)
    assert run(scene) == 130
    assert "interrupted" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == [scene.name]
