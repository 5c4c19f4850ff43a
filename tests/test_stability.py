"""The stability laboratory's claims: robust methods meet their oracles, and naive ones fail as the catalogue says."""

from __future__ import annotations

import math
import re
from typing import Any

import numpy as np
import pytest
from pictures import everything
from stability import studies
from stability.study import DOUBLE, NAIVE, ROBUST, Curve, Study, broken_claims, kernel_options, run

import feeler


@pytest.mark.parametrize("study", [pytest.param(s, marks=[pytest.mark.slow] * s.slow, id=str(s)) for s in studies()])
def test_a_row_of_the_catalogue(study: Study) -> None:
    """NUMERICS, every row: see tests/stability."""
    result = run(study, with_cost=False)
    assert not broken_claims(result), "\n".join(broken_claims(result))
    curves = [curve for panel in result.panels for curve in panel.curves]
    assert any(curve.kind == NAIVE and (curve.fails or curve.figures) for curve in curves), "no failure is shown"
    assert [curve.name for curve in curves if not curve.claims_something()] == [], "of these nothing is claimed"
    assert all(len(curve.values) == len(panel.x) for panel in result.panels for curve in panel.curves)
    assert any(curve.kind == ROBUST and curve.bound is not None for curve in curves)
    assert any(curve.kind == DOUBLE for curve in curves)


@pytest.mark.parametrize(
    "claims",
    [
        {"bound": 0.5}, {"bound": [None, 1, 2, 1]}, {"bound": 9, "fails": 2.1}, {"fails": [0, None, 2.1, None]},
        {"fails": [None, 0, None, None]}, {"figures": [0, None, 1, None]}, {"figures": [0, 2, None, None]},
        {"figures": [0.1, None, None, None]}, {"bound": [math.nan] * 4}, {"fails": math.nan}, {"figures": [math.nan] * 4},
    ],
)  # fmt: skip
def test_what_is_not_as_claimed_is_found(claims: dict[str, Any]) -> None:
    assert Curve("", NAIVE, [0, None, 2, 1.5], **claims).broken_claims()


def test_what_is_as_claimed_is_not() -> None:
    claims: dict[str, Any] = {"bound": [0, 0, None, 1.5], "fails": [0, None, 2, 1], "figures": [0, None, 1.6, 1.9]}
    assert Curve("", NAIVE, [0, None, 2, 1.5], **claims).broken_claims() == []
    assert Curve("", NAIVE, [0, None, 2, 1.5], 2, 2).broken_claims() == []
    with pytest.raises(AssertionError, match="3 claims for 4 values"):
        Curve("", NAIVE, [0, None, 2, 1.5], [2, 2, 2]).broken_claims()


@pytest.mark.parametrize("claims", [{"bound": 9}, {"bound": [9, 9, None]}, {"fails": 1}, {"fails": [1, 1, None]}, {}])
def test_no_number_is_as_nothing_claims(claims: dict[str, Any]) -> None:
    assert Curve("", NAIVE, [1, 2, math.nan], **claims).broken_claims()
    assert not Curve("", NAIVE, [1, 2, None], **claims).broken_claims()


def test_every_row_is_here() -> None:
    assert {study.row for study in studies()} == set(range(1, 27))
    assert {study.row for study in studies() if study.cost} == set(range(1, 27))


@pytest.mark.slow
@pytest.mark.parametrize("row", [12, 18, 19])
def test_costs(row: int) -> None:
    """Of a function, and of pictures: many mirrors more cost more than twice, and pruned trees less than half."""
    cost = next(study.cost for study in studies() if study.row == row and study.cost)
    found = cost.measure()
    assert 0 < found["low"] <= found["ratio"] <= found["high"]
    assert found["ratio"] == pytest.approx(found["robust_ns"] / found["naive_ns"], rel=0.5)
    assert row == 12 or (found["ratio"] > 2) == (row == 18) == (found["ratio"] > 0.5)


@pytest.mark.slow
@pytest.mark.parametrize("lanes", [1, 4])
def test_naive_kernels_render(lanes: int) -> None:
    """All options at once, as a whole picture: they reach a render, in lanes too, and change it."""
    names = sorted(set(re.findall(r"\bdefined\((NAIVE_\w+)\)", feeler.kernel_source())))
    assert len(names) >= 19
    with kernel_options(
        " ".join(f"-D{name}=1e-4" if name in ("NAIVE_TMIN", "NAIVE_OFFSET") else f"-D{name}" for name in names)
    ):
        naive = feeler.Scene(everything()).render(samples=lanes, lanes=lanes).pixels
    robust = feeler.Scene(everything()).render(samples=lanes, lanes=lanes).pixels
    assert 0.2 < np.isclose(naive, robust, atol=0.1).all(-1).mean() < 1
