"""Random whole scenes: whatever passes validation renders without a NaN, an infinity or a negative pixel, by any kernel and
with or without the tree.
"""

from __future__ import annotations

from typing import Any

import hypothesis
import numpy as np
import pytest
from pictures import same_bits
from whole_scenes import scenes

import feeler


def load(description: dict[str, Any]) -> feeler.Scene:
    """Extremes may make a shape degenerate, or put the look-at point at the eye: such scenes are refused, and no matter."""
    try:
        return feeler.Scene(description)
    except feeler.Error as error:
        if error.kind != "bad input":
            raise
        hypothesis.reject()


def check(description: dict[str, Any], **settings: Any) -> None:
    scene = load(description)
    image = scene.render(general=True, **settings)
    assert np.isfinite(image.pixels).all()
    assert (image.pixels >= 0).all()
    brute = scene.render(general=True, brute_force=True, **settings)
    assert same_bits(brute.pixels, image.pixels)
    assert brute.stats["rays"] == image.stats["rays"]


@hypothesis.settings(max_examples=20)
@hypothesis.given(scenes())
def test_no_pixel_is_nan_or_infinite(description: dict[str, Any]) -> None:
    check(description)


@pytest.mark.slow
@hypothesis.settings(max_examples=20_000, suppress_health_check=list(hypothesis.HealthCheck))
@hypothesis.given(scenes())
def test_no_pixel_of_thousands_is(description: dict[str, Any]) -> None:
    check(description)


@pytest.mark.slow
@hypothesis.settings(max_examples=500, suppress_health_check=list(hypothesis.HealthCheck))
@hypothesis.given(scenes(filtered_shadows=True, smooth_terminator=True))
def test_nor_with_extensions(description: dict[str, Any]) -> None:
    check(description)


@pytest.mark.slow
@hypothesis.settings(max_examples=300, suppress_health_check=list(hypothesis.HealthCheck))
@hypothesis.given(scenes())
def test_nor_in_double(description: dict[str, Any]) -> None:
    check(description, level="reference")


@pytest.mark.slow
@hypothesis.settings(max_examples=300, suppress_health_check=list(hypothesis.HealthCheck))
@hypothesis.given(scenes())
def test_nor_of_packets(description: dict[str, Any]) -> None:
    check(description, samples=5)


@pytest.mark.slow
@hypothesis.settings(max_examples=200, suppress_health_check=list(hypothesis.HealthCheck))
@hypothesis.given(scenes())
def test_channels_are_numbers(description: dict[str, Any]) -> None:
    scene = load(description)
    found = scene.render(general=True, channels="all").channels
    assert not any(np.isnan(plane).any() for plane in found.values())
    assert np.isfinite(found["position"]).all() and (abs(found["normal"]) < 1.001).all() and (found["depth"] >= 0).all()
    assert ((found["margin"] >= 0) & (found["margin"] <= 16)).all()
    brute = scene.render(general=True, channels="all", brute_force=True).channels
    assert all(same_bits(brute[name], plane) for name, plane in found.items())


@hypothesis.settings(max_examples=3, phases=[hypothesis.Phase.generate])
@hypothesis.given(scenes())
def test_specialised_is_general(description: dict[str, Any]) -> None:
    scene = load(description)
    assert same_bits(scene.render().pixels, scene.render(general=True).pixels)


@pytest.mark.slow
@hypothesis.settings(
    max_examples=60, phases=[hypothesis.Phase.generate], suppress_health_check=list(hypothesis.HealthCheck)
)
@hypothesis.given(scenes())
def test_many_specialised_are_general(description: dict[str, Any]) -> None:
    scene = load(description)
    assert same_bits(scene.render().pixels, scene.render(general=True).pixels)
