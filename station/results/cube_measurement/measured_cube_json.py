"""A measured cube as JSON, ``measured-cube/1``."""

from typing import Any

import numpy as np

from fixtures_db.calibration import utc_text
from procedures.bench.cube_drift import CubeComparison, CubeDrift
from station.results.cube_measurement.known_faces import CubeStudy
from station.results.cube_measurement.observable import not_observable

FORMAT = "measured-cube/1"


def document(found: CubeStudy) -> dict[str, Any]:
    """Return all that was found as JSON-ready values; what there is not is left out."""
    cube, known = found.measured.cube, found.with_this
    said: dict[str, Any] = {
        "format": FORMAT,
        "cube": found.cube,
        "measured_utc": utc_text(found.measured_utc),
        "values_rad": dict(zip(cube.names, cube.value.tolist(), strict=True)),
        "std_rad": dict(zip(cube.names, np.sqrt(np.diag(cube.covariance)).tolist(), strict=True)),
        "covariance": {"names": list(cube.names), "matrix": cube.covariance.tolist()},
        "units": [
            {
                "unit": share.unit,
                "campaigns": dict(found.campaigns[share.unit]),
                "quadratic_std_g": share.quadratic_std,
                "quadratic_left_g": share.quadratic_left.tolist(),
                "by_quadratic_rad_per_g": share.by_quadratic.tolist(),
            }
            for share in found.measured.shares
        ],
        "not_observable": not_observable(found.measured),
        "warnings": list(found.warnings),
    }
    if found.measured.dof:
        m = found.measured
        said["consistency"] = {"chi2": m.chi2, "dof": m.dof, "p_value": m.p_value}
    if known.comparison is not None:
        said["against_certificate"] = _comparison(known.comparison)
    if (moved := known.drift) is not None:
        said["drift"] = _drift(moved)
    return said


def _comparison(found: CubeComparison) -> dict[str, Any]:
    rows = {
        name: {"shift_rad": d, "std_rad": s, "shift_sigma": d / s}
        for name, d, s in zip(found.names, found.difference.tolist(), found.std.tolist(), strict=True)
    }
    return {"values": rows, "chi2": found.chi2, "p_value": found.p_value}


def _drift(moved: CubeDrift) -> dict[str, Any]:
    rows: dict[str, dict[str, float]] = {}
    for i, name in enumerate(moved.names):
        rows[name] = {
            "shift_rad": float(moved.shift[i]),
            "shift_sigma": float(moved.shift[i] / moved.shift_std[i]),
            "chi2": float(moved.chi2[i]),
            "p_adjusted": float(moved.p_adjusted[i]),
        }
        if np.isfinite(moved.trend_std[i]):
            rows[name] |= {
                "trend_rad_per_month": float(moved.trend[i]),
                "trend_std_rad_per_month": float(moved.trend_std[i]),
            }
    return {"dof": moved.dof, "values": rows, "changed": list(moved.changed)}
