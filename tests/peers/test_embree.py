"""The classic scenes against a Whitted tracer on Embree's own intersectors."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest
from peer_pictures import FINE, FOLDER, SIZE, Pixels, compare, read_pfm, render, save_difference

pytestmark = pytest.mark.peers

SCENES = ["balls", "mount", "tetra"]


def trace(tracer: Path, scene: Path, out: Path) -> Pixels:
    command: list[str | Path] = [tracer, scene, str(SIZE), "1", "1", out]
    subprocess.run(command, check=True, timeout=600, stdout=subprocess.DEVNULL)
    return read_pfm(out)


@pytest.mark.parametrize("name", SCENES)
def test_pictures(program: Path, embree: Path, spd: Path, name: str) -> None:
    ours, fine = render(program, spd / f"{name}.nff", SIZE), render(program, spd / f"{name}.nff", FINE)
    theirs = trace(embree, spd / f"{name}.nff", FOLDER / f"{name}-embree.pfm")
    save_difference(f"{name}-embree", ours, theirs)
    found = compare(ours, theirs, fine)
    print(name, found)
    assert found.mean <= 0.002
    assert found.off <= 0.015
    assert found.unexplained <= (0.0006 if name == "balls" else 0.00003)


# The smallest of the balls have a radius of 62 of its epsilons, so that its mirror images of mirror images are elsewhere: our
# picture in double precision differs as much. With a smaller epsilon (below) the limit is kept.
EPSILON_TOO_LARGE = pytest.mark.xfail(reason="1.6 % of balls by the worst channel: the peer's epsilon", strict=True)


@pytest.mark.parametrize("name", [pytest.param("balls", marks=EPSILON_TOO_LARGE), "mount", "tetra"])
def test_pictures_by_the_worst_channel(program: Path, embree: Path, spd: Path, name: str) -> None:
    ours, fine = render(program, spd / f"{name}.nff", SIZE), render(program, spd / f"{name}.nff", FINE)
    theirs = trace(embree, spd / f"{name}.nff", FOLDER / f"{name}-embree.pfm")
    assert compare(ours, theirs, fine).channel_off <= 0.015


@pytest.mark.parametrize("name", SCENES)
def test_pictures_without_its_epsilon(program: Path, close_embree: Path, spd: Path, name: str) -> None:
    ours, fine = render(program, spd / f"{name}.nff", SIZE), render(program, spd / f"{name}.nff", FINE)
    theirs = trace(close_embree, spd / f"{name}.nff", FOLDER / f"{name}-embree-close.pfm")
    save_difference(f"{name}-embree-close", ours, theirs)
    found = compare(ours, theirs, fine)
    print(name, found)
    assert found.mean <= (0.0004 if name == "balls" else 0.00001)
    assert found.channel_off <= (0.003 if name == "balls" else 0.0001)
    assert found.unexplained <= 0.0001


@pytest.mark.parametrize("name", SCENES)
def test_what_edges_do_not_explain(program: Path, spd: Path, name: str) -> None:
    ours, fine = render(program, spd / f"{name}.nff", SIZE), render(program, spd / f"{name}.nff", FINE)
    assert compare(ours, ours, fine).mean == 0
    brighter = ours * 1.1
    assert compare(ours, brighter, fine).unexplained > 0.3
    displaced = ours.copy()
    displaced[:, 3:] = ours[:, :-3]
    assert compare(ours, displaced, fine).unexplained > 0.03
    blot = ours.copy()
    blot[10:20, 10:20] += 0.1  # nothing but floor or background there
    assert compare(ours, blot, fine).unexplained > 0.0002
