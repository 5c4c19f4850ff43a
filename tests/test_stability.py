"""The stability laboratory's claims: robust methods meet their oracles, and naive ones fail as the catalogue says."""

from __future__ import annotations

import re

import numpy as np
import pytest
from pictures import everything
from stability import studies
from stability.study import DOUBLE, ROBUST, Study, broken_claims, kernel_options, run

import feeler


@pytest.mark.parametrize("study", [pytest.param(s, marks=[pytest.mark.slow] * s.slow, id=str(s)) for s in studies()])
def test_a_row_of_the_catalogue(study: Study) -> None:
    """NUMERICS, every row: see tests/stability."""
    result = run(study, with_cost=False)
    assert not broken_claims(result), "\n".join(broken_claims(result))
    curves = [curve for panel in result.panels for curve in panel.curves]
    assert any(curve.fails is not None for curve in curves), "no failure is shown"
    assert all(len(curve.values) == len(panel.x) for panel in result.panels for curve in panel.curves)
    assert any(curve.kind == ROBUST and curve.bound is not None for curve in curves)
    assert any(curve.kind == DOUBLE for curve in curves)


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
