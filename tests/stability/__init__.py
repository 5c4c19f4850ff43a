"""The stability laboratory: every row of the catalogue of numerical troubles (docs/numerics.md) as a study of the real kernels,
naive methods beside the robust ones. `make stability` runs them all; tests/test_stability.py holds them to their claims.
"""

from __future__ import annotations

from .study import Study


def studies() -> list[Study]:
    """All of them, by row."""
    from . import bodies, boxes, depth, directions, faces, far, lights, normals, starts

    modules = (bodies, faces, boxes, starts, directions, depth, far, lights, normals)
    return sorted((study for module in modules for study in module.STUDIES), key=lambda study: study.row)
