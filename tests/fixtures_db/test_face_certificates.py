"""What a face's certificate may be: its covariance symmetric, none negative, exactly known allowed."""

from typing import Any

import numpy as np
import pytest

from fixtures_db.face_certificates import check_certificate, face_certificate
from fixtures_db.schema import FaceCertificateRow


def row(**changed: Any) -> FaceCertificateRow:
    numbers = {
        "up_tilt_1_rad": 1e-5, "up_tilt_2_rad": -2e-5, "covariance_11_rad2": 4e-12, "covariance_12_rad2": 1e-12,
        "covariance_22_rad2": 9e-12,
    }  # fmt: skip
    return FaceCertificateRow(resting="x_up", **(numbers | changed))


def test_a_row_is_the_tilts_and_their_covariance() -> None:
    face = face_certificate(row())
    np.testing.assert_array_equal(face.up_tilt, [1e-5, -2e-5])
    np.testing.assert_array_equal(face.covariance, [[4e-12, 1e-12], [1e-12, 9e-12]])
    check_certificate(row())


@pytest.mark.parametrize("covariance", [(0.0, 0.0, 0.0), (4e-12, 0.0, 0.0), (4.0, -6.0, 9.1)])
def test_what_is_known_exactly_is_a_certificate(covariance: tuple[float, float, float]) -> None:
    one, both, other = covariance
    check_certificate(row(covariance_11_rad2=one, covariance_12_rad2=both, covariance_22_rad2=other))


@pytest.mark.parametrize("covariance", [(-1e-14, 0.0, 1.0), (1.0, 0.0, -1e-14), (4.0, 6.1, 9.0)])
def test_a_variance_below_nought_is_none(covariance: tuple[float, float, float]) -> None:
    one, both, other = covariance
    with pytest.raises(ValueError, match="expected symmetric"):
        check_certificate(row(covariance_11_rad2=one, covariance_12_rad2=both, covariance_22_rad2=other))


def test_a_face_that_no_cube_has_is_refused() -> None:
    bad = row()
    bad.resting = "w_up"
    with pytest.raises(ValueError, match="'w_up' is none of x_up"):
        check_certificate(bad)
