"""A row of a measured cube, and what it says."""

import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from fixtures_db.schema import CubeMeasurementRow
from procedures.arrays import FloatArray
from procedures.campaign.campaign import MeasuredCube
from procedures.campaign.measured_cube import NAMES, CubeMeasurement, UnitShare

MAX_TILT = 0.1  # rad; beyond it a tilt is a slip of the pen


def measurement(row: CubeMeasurementRow) -> CubeMeasurement:
    """Return a row as it was measured; raise `ValueError` if it is no measurement."""
    try:
        values, covariance, sources = (json.loads(t) for t in (row.values_rad, row.covariance_rad2, row.sources))
        names, value = tuple(values), np.array(list(values.values()), dtype=float)
        shares = tuple(_share(source, len(names)) for source in sources)
        units = tuple(share.unit for share in shares)
        cube = MeasuredCube(names, value, np.array(covariance, dtype=float), units)
        return CubeMeasurement(cube, _noise(cube, shares), shares)
    except (TypeError, KeyError, AttributeError, ValueError) as error:
        raise ValueError(f"measurement of cube {row.cube_id!r}: {error}") from error


def check_measurement(row: CubeMeasurementRow) -> None:
    """Raise `ValueError` if a row is no measurement of a cube."""
    cube, name = measurement(row).cube, f"measurement of cube {row.cube_id!r}"
    n, C = len(cube.names), cube.covariance
    if not n or not set(cube.names) <= set(NAMES):
        raise ValueError(f"{name}: values {', '.join(cube.names)}, expected of {', '.join(NAMES)}")
    if not np.all(np.abs(cube.value) < MAX_TILT):
        raise ValueError(f"{name}: values {cube.value.tolist()} rad, expected each under {MAX_TILT} rad")
    if C.shape != (n, n) or not np.allclose(C, C.T, rtol=1e-9, atol=0) or not np.linalg.eigvalsh(C)[0] > 0:
        raise ValueError(f"{name}: covariance, expected symmetric ({n}, {n}), positive definite")


def _share(source: Mapping[str, Any], n: int) -> UnitShare:
    left, by = (np.array(source[key], dtype=float) for key in ("quadratic_left", "by_quadratic"))
    if by.shape != (n, 3) or left.shape != (3,):
        raise ValueError(f"by_quadratic is {by.shape} and quadratic_left {left.shape}, expected ({n}, 3) and (3,)")
    return UnitShare(str(source["unit"]), by, float(source["quadratic_std"]), left)


def _noise(cube: MeasuredCube, shares: Sequence[UnitShare]) -> FloatArray:
    return cube.covariance - sum(
        (s.quadratic_std**2 * s.by_quadratic @ s.by_quadratic.T for s in shares), np.zeros(cube.covariance.shape)
    )
