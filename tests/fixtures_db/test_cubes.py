from contextlib import nullcontext
from datetime import date

import numpy as np
import pytest

from fixtures_db.database import Database
from fixtures_db.errors import AlreadyThere, NotInDatabase
from fixtures_db.fixture_measurements import certify_faces, check_certificate, cube, drawing
from fixtures_db.fixtures import add_fixture, fixture_row
from fixtures_db.schema import CubeRow, FaceCertificateRow
from procedures.campaign.campaign import FaceCertificate
from tests.fixtures_db.factory import NOON
from tests.refusals import refused


def _face(east: float) -> FaceCertificate:
    return FaceCertificate(np.array([east, -2e-5]), np.array([[25e-12, 1e-12], [1e-12, 16e-12]]))


@pytest.fixture
def certified(db: Database) -> Database:
    with db.write() as session:
        add_fixture(session, CubeRow(id="CUBE-7", side_mm=400.0, tolerances=drawing({"t1": 0.02})))
        certify_faces(
            session, "CUBE-7", {"x_up": _face(1e-5), "z_down": _face(3e-5)}, source="CMM", measured_utc=NOON
        )
    with db.write() as session:
        certify_faces(
            session, "CUBE-7", {"x_up": _face(2e-5)}, source="CMM", measured_utc=NOON, due_date=date(2027, 3, 4)
        )
    return db


def test_the_newest_certificate_of_each_face_enters_the_fixture(certified: Database) -> None:
    with certified.read() as session:
        fixture = cube(session, "CUBE-7")
        assert len(fixture_row(session, CubeRow, "CUBE-7").certificates) == 3
        assert fixture_row(session, CubeRow, "CUBE-7").due_date == date(2027, 3, 4)
        assert fixture_row(session, CubeRow, "CUBE-7").tolerances[0].tolerance_mm == 0.02
    assert fixture.id == "CUBE-7"
    assert list(fixture.faces) == ["x_up", "z_down"]
    np.testing.assert_array_equal(fixture.faces["x_up"].up_tilt, [2e-5, -2e-5])
    np.testing.assert_array_equal(fixture.faces["z_down"].covariance, _face(0).covariance)
    np.testing.assert_array_equal(fixture.C_sb, np.eye(3))


def test_names_are_checked(certified: Database) -> None:
    with certified.write() as session:
        with pytest.raises(AlreadyThere):
            add_fixture(session, CubeRow(id="CUBE-7", side_mm=400.0))
        with pytest.raises(NotInDatabase, match="CUBE-7, P1"):
            cube(session, "CUBE-8")
        with pytest.raises(ValueError, match="x_up"):
            certify_faces(session, "P1", {"top": _face(0)}, source="CMM", measured_utc=NOON)
        bad = FaceCertificate(np.zeros(2), np.array([[1.0, 2.0], [2.0, 1.0]]))
        with pytest.raises(ValueError, match="covariance"):
            certify_faces(session, "P1", {"x_up": bad}, source="CMM", measured_utc=NOON)
        with pytest.raises(ValueError, match="positive"):
            add_fixture(session, CubeRow(id="flat", side_mm=0.0))


@pytest.mark.parametrize(
    ("covariance", "is_one"),
    [
        ((0.0, 0.0, 0.0), True), ((4e-12, 0.0, 0.0), True), ((4.0, -6.0, 9.1), True),  # known exactly, too
        ((-1e-14, 0.0, 1.0), False), ((1.0, 0.0, -1e-14), False), ((4.0, 6.1, 9.0), False),
    ],
)  # fmt: skip
def test_a_covariance_is_symmetric_with_no_variance_below_zero(
    covariance: tuple[float, float, float], is_one: bool
) -> None:
    names = ("covariance_11_rad2", "covariance_12_rad2", "covariance_22_rad2")
    columns = dict(zip(names, covariance, strict=True))
    row = FaceCertificateRow(resting="x_up", up_tilt_1_rad=1e-5, up_tilt_2_rad=-2e-5, **columns)
    with nullcontext() if is_one else refused(ValueError):
        check_certificate(row)
