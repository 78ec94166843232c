"""What a certificate says that was done otherwise than usual."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from station.results import measurement_circumstances


@pytest.mark.parametrize(
    ("gyro", "accelerometer", "said"),
    [
        (0.2, 3e-5, ["warm-up was skipped: biases may drift by 0.2 deg/h and 30 ug (1 sigma)"]),
        (0.2, None, ["warm-up was skipped: biases may drift by 0.2 deg/h and 0 ug (1 sigma)"]),
        (None, 3e-5, ["warm-up was skipped: biases may drift by 0 deg/h and 30 ug (1 sigma)"]),
        (None, None, []),
    ],
)
def test_a_bias_that_nothing_is_said_of_does_not_drift(
    gyro: float | None, accelerometer: float | None, said: list[str], tmp_path: Path
) -> None:
    procedure = SimpleNamespace(
        unsettled_gyro_deg_h=gyro, unsettled_accelerometer_g=accelerometer, closure_widened_from_deg=None
    )
    row: Any = SimpleNamespace(folder=str(tmp_path), steps=())
    tables: Any = SimpleNamespace(procedure=procedure, dwell=())
    assert measurement_circumstances._deviations(row, tables, {}) == said  # noqa: SLF001
