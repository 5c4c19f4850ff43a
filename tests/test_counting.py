"""What tests/peers/limit.py builds the kernels with: counts in place of the rays, and every traversal twice."""

import itertools
from pathlib import Path

import numpy as np
import pytest
from spheres import write_spheres

import feeler


@pytest.mark.parametrize("samples", [1, 16])
def test_steps_are_counted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, samples: int) -> None:
    scene = feeler.load(write_spheres(tmp_path / "spheres.nff"))
    usual = scene.render(samples=samples)
    rays = usual.stats["rays"]
    later = rays["reflection"] + rays["transmission"] + rays["shadow"]
    least, sent = rays["eye_hits"] + later, rays["eye"] + later  # eye rays of a pixel that sees nothing go no way
    found = []
    for options in ("-DCOUNTING=1", "-DCOUNTING=2", "-DTRAVERSALS=2"):
        monkeypatch.setenv("FEELER_KERNEL_OPTIONS", options)
        image = scene.render(samples=samples)
        assert np.array_equal(image.pixels, usual.pixels)
        found.append([image.stats["rays"][name] for name in ("reflection", "transmission", "shadow")])
    (lone, nodes, _), (beams, boxes, _), _ = found
    if samples == 1:
        assert least <= lone <= sent
        assert nodes >= lone
        assert (beams, boxes) == (0, 0)
    else:
        assert least / 16 <= beams < least
        assert boxes + lone >= beams  # a way asks a node at least, or its rays go on alone


def test_pixels_are_passed_over_in_every_direction(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of the same scene, mirrored, as many eye rays are sent: a fourth at most, and no other rays are."""
    monkeypatch.setenv("FEELER_KERNEL_OPTIONS", "-DCOUNTING=1")
    sent = []
    for x, y, z in itertools.product((-4, 4), (-3, 3), (-5, 5)):
        camera = {"eye": [x, y, z], "look_at": [0, 0, 0], "fov": 40}
        scene = feeler.Scene({"camera": camera, "shadows": False, "objects": [{"sphere": {"radius": 0.3}}]})
        sent.append(scene.render(size=(64, 64)).stats["rays"]["reflection"])  # that is, ways of one ray
    assert 0 < max(sent) < 64 * 64 / 4
    assert max(sent) - min(sent) < 0.1 * max(sent)
