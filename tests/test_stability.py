"""The stability laboratory's claims: robust methods meet their oracles, and naive ones fail as the catalogue says."""

from __future__ import annotations

import pytest
from stability import studies
from stability.study import ROBUST, Study, broken_claims, run


@pytest.mark.parametrize("study", [pytest.param(s, marks=[pytest.mark.slow] * s.slow, id=str(s)) for s in studies()])
def test_a_row_of_the_catalogue(study: Study) -> None:
    """NUMERICS, every row: see tests/stability."""
    result = run(study, with_cost=False)
    assert not broken_claims(result), "\n".join(broken_claims(result))
    curves = [curve for panel in result.panels for curve in panel.curves]
    assert any(curve.fails is not None for curve in curves), "no failure is shown"
    assert all(len(curve.values) == len(panel.x) for panel in result.panels for curve in panel.curves)
    assert any(curve.kind == ROBUST for curve in curves) or study.row == 22


def test_every_row_is_here() -> None:
    assert {study.row for study in studies()} == set(range(1, 27))
