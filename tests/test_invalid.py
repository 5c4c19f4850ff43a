"""Bad scene files: each folder of tests/invalid is one case, and a new one is files only.

input.*   the scene (or `scene` holds the name to give, where that is no such file)
error     what stderr must hold
exit      the exit code
"""

import os
import pathlib
import subprocess

import pytest

ROOT = pathlib.Path(__file__).resolve().parent.parent
FEELER = pathlib.Path(os.environ.get("FEELER", ROOT / "build" / "feeler"))
CASES = sorted(path.parent for path in (ROOT / "tests" / "invalid").glob("*/error"))


def scene_of(case: pathlib.Path) -> str:
    named = case / "scene"
    if named.exists():
        return named.read_text().strip()
    return next(path.name for path in sorted(case.iterdir()) if path.stem == "input")


@pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)
def test_invalid(case: pathlib.Path) -> None:
    done = subprocess.run(
        [FEELER, "info", scene_of(case)], cwd=case, capture_output=True, text=True, timeout=60, check=False
    )
    assert done.stderr == (case / "error").read_text()
    assert done.returncode == int((case / "exit").read_text())
    assert done.stdout == ""


def test_there_are_cases() -> None:
    assert len(CASES) > 100
