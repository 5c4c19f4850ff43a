"""Random whole scenes: whatever passes validation renders without a NaN, an infinity or a negative pixel, by any kernel and
with or without the tree.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from typing import Any

import hypothesis
import numpy as np
import pytest
from pictures import same_bits
from whole_scenes import scenes

import feeler

ALL = list(hypothesis.HealthCheck)
GENERAL = scenes()
loaded: Counter[str] = Counter()  # in the test that runs: scenes that were accepted, and that were refused


def load(description: dict[str, Any]) -> feeler.Scene:
    """Extremes may make a shape degenerate, or put the look-at point at the eye: such scenes are refused, and no matter as long
    as most are accepted.
    """
    try:
        scene = feeler.Scene(description)
    except feeler.Error as error:
        if error.kind != "bad input":
            raise
        loaded["refused"] += 1
        hypothesis.reject()
    loaded["accepted"] += 1
    return scene


def of_scenes(count: int, drawn: Any = GENERAL, **settings: Any) -> Callable[[Callable[..., None]], Callable[[], None]]:
    """Asks this of so many scenes that are accepted. With a generator whose scenes are mostly refused, or of which there are only a
    few, the test fails instead of asking little.
    """

    def decorate(ask: Callable[..., None]) -> Callable[[], None]:
        ask_each = hypothesis.settings(max_examples=count, **settings)(hypothesis.given(drawn)(ask))

        def test() -> None:
            loaded.clear()
            ask_each()
            assert loaded["accepted"] >= count
            assert loaded["refused"] <= count / 2 + 5, "more than a third"

        test.__name__, test.__doc__ = ask.__name__, ask.__doc__
        return test

    return decorate


def check(description: dict[str, Any], **settings: Any) -> None:
    scene = load(description)
    image = scene.render(general=True, **settings)
    assert np.isfinite(image.pixels).all()
    assert (image.pixels >= 0).all()
    brute = scene.render(general=True, brute_force=True, **settings)
    assert same_bits(brute.pixels, image.pixels)
    assert brute.stats["rays"] == image.stats["rays"]


@of_scenes(20)
def test_no_pixel_is_nan_or_infinite(description: dict[str, Any]) -> None:
    check(description)


@pytest.mark.slow
@of_scenes(20_000, suppress_health_check=ALL)
def test_no_pixel_of_thousands_is(description: dict[str, Any]) -> None:
    check(description)


@pytest.mark.slow
@of_scenes(500, scenes(filtered_shadows=True, smooth_terminator=True), suppress_health_check=ALL)
def test_nor_with_extensions(description: dict[str, Any]) -> None:
    check(description)


@pytest.mark.slow
@of_scenes(300, suppress_health_check=ALL)
def test_nor_in_double(description: dict[str, Any]) -> None:
    check(description, level="reference")


@pytest.mark.slow
@of_scenes(300, suppress_health_check=ALL)
def test_nor_of_packets(description: dict[str, Any]) -> None:
    check(description, samples=5)


@pytest.mark.slow
@of_scenes(200, suppress_health_check=ALL)
def test_channels_are_numbers(description: dict[str, Any]) -> None:
    scene = load(description)
    found = scene.render(general=True, channels="all").channels
    assert not any(np.isnan(plane).any() for plane in found.values())
    assert np.isfinite(found["position"]).all() and (abs(found["normal"]) < 1.001).all() and (found["depth"] >= 0).all()
    assert ((found["margin"] >= 0) & (found["margin"] <= 16)).all()
    brute = scene.render(general=True, channels="all", brute_force=True).channels
    assert all(same_bits(brute[name], plane) for name, plane in found.items())


@of_scenes(3, phases=[hypothesis.Phase.generate])
def test_specialised_is_general(description: dict[str, Any]) -> None:
    scene = load(description)
    assert same_bits(scene.render().pixels, scene.render(general=True).pixels)


@pytest.mark.slow
@of_scenes(60, phases=[hypothesis.Phase.generate], suppress_health_check=ALL)
def test_many_specialised_are_general(description: dict[str, Any]) -> None:
    scene = load(description)
    assert same_bits(scene.render().pixels, scene.render(general=True).pixels)
