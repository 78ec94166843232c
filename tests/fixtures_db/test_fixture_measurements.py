from contextlib import nullcontext
from dataclasses import replace
from datetime import UTC, date, datetime

import numpy as np
import pytest
from sqlalchemy import text

from fixtures_db.append_only_rows import verify_dates
from fixtures_db.database import Database
from fixtures_db.errors import AlreadyThere, NotInDatabase
from fixtures_db.fixture_measurements import (
    add_measurement,
    certify_faces,
    check_certificate,
    check_measurement,
    cube,
    drawing,
    measurement,
    measurements,
)
from fixtures_db.fixtures import add_fixture, due, fixture_row
from fixtures_db.migrations.versions.v0005_measured_cubes import FIRST_DUE
from fixtures_db.schema import CubeMeasurementRow, CubeRow, FaceCertificateRow
from procedures.campaign.campaign import FaceCertificate
from tests.fixtures_db.factory import LATER, NOON, measured_cube
from tests.refusals import refused

CAMPAIGNS = {"FOG-3 S1": {"2026-03-04": "ab" * 32}}
FACE = FaceCertificate(np.array([1e-5, -2e-5]), 25e-12 * np.eye(2))


@pytest.fixture
def measured(db: Database) -> Database:
    with db.write() as session:
        add_fixture(session, CubeRow(id="C8", side_mm=400.0))
        for at, moved in ((NOON, 0.0), (LATER, 5e-6)):
            found, until = measured_cube(moved), date(at.year + 1, 3, 4)
            add_measurement(session, "C8", found, campaigns=CAMPAIGNS, measured_utc=at, due_date=until)
    return db


def test_what_is_stored_comes_back_as_it_was_measured(measured: Database) -> None:
    with measured.read() as session:
        first, last = (measurement(row) for row in measurements(fixture_row(session, CubeRow, "C8")))
    was = measured_cube(5e-6)
    assert first.cube.value[0] == 0.0
    assert last.cube.names == was.cube.names
    np.testing.assert_array_equal(last.cube.value, was.cube.value)
    np.testing.assert_array_equal(last.cube.covariance, was.cube.covariance)
    np.testing.assert_allclose(last.noise, was.noise, atol=1e-20)
    np.testing.assert_array_equal(last.shares[0].by_quadratic, was.shares[0].by_quadratic)
    assert last.cube.units == ("FOG-3 S1",)


def test_a_solve_takes_the_last_measurement_and_a_certificate_of_a_face_before_it(measured: Database) -> None:
    with measured.write() as session:
        taken = cube(session, "C8")
        assert taken.measured is not None
        assert taken.measured.value[0] == 5e-6
        certify_faces(session, "C8", {"x_up": FACE}, source="CMM", measured_utc=NOON)
        taken = cube(session, "C8")
        assert taken.measured is None
        assert list(taken.faces) == ["x_up"]


def test_a_measured_cube_is_due_with_its_last_measurement_and_a_certified_one_with_its_first_face(
    measured: Database,
) -> None:
    with measured.write() as session:
        assert (row := fixture_row(session, CubeRow, "C8")).due_date == date(2027, 3, 4)
        assert row.certificate_date == LATER.date()
        assert [one.name for one in due(session, date(2027, 3, 4))] == ["C8"]
        for face, day in (("x_up", date(2030, 1, 1)), ("y_up", date(2029, 1, 1)), ("z_up", None)):
            certify_faces(session, "C8", {face: FACE}, source="CMM", measured_utc=NOON, due_date=day)
        assert fixture_row(session, CubeRow, "C8").due_date == date(2029, 1, 1)  # z_up has no say
        certify_faces(session, "C8", {"y_up": FACE}, source="CMM", measured_utc=LATER)
        assert fixture_row(session, CubeRow, "C8").due_date == date(2030, 1, 1)  # y_up holds without end now
        assert verify_dates(session) == []


@pytest.mark.parametrize(
    ("column", "value", "reported"),
    [
        ("values_rad", '{"parallelism.x.w": 1e-5}', "by_quadratic"),
        ("values_rad", "[]", ""),
        ("covariance_rad2", "[[1.0]]", ""),
        ("values_rad", str(dict.fromkeys(measured_cube().cube.names, 1.0)).replace("'", '"'), ""),
        ("sources", '[{"unit": "S"}]', "quadratic_left"),
        ("sources", "{", ""),
    ],
)
def test_what_is_no_measurement_is_refused(column: str, value: str, reported: str, measured: Database) -> None:
    with measured.read() as session:
        row = measurements(fixture_row(session, CubeRow, "C8"))[0]
    columns = {c: getattr(row, c) for c in ("cube_id", "values_rad", "covariance_rad2", "sources", "measured_utc")}
    with pytest.raises(ValueError, match=f"C8.*{reported}"):
        check_measurement(CubeMeasurementRow(**columns | {column: value}))


def test_a_covariance_that_is_none_and_a_name_that_is_none_are_refused(measured: Database) -> None:
    was = measured_cube()
    wrong = (
        (replace(was.cube, covariance=-was.cube.covariance), "positive definite"),
        (replace(was.cube, names=("parallelism.x.w", *was.cube.names[1:])), "x.w"),
    )
    for found, reported in wrong:
        with pytest.raises(ValueError, match=reported), measured.write() as session:
            add_measurement(session, "C8", replace(was, cube=found), campaigns=CAMPAIGNS, measured_utc=LATER)
    with pytest.raises(NotInDatabase), measured.write() as session:
        add_measurement(session, "C9", was, campaigns=CAMPAIGNS, measured_utc=datetime(2026, 1, 1, tzinfo=UTC))


def test_a_cube_of_an_older_database_is_dated_again_by_the_first_of_its_faces(db: Database) -> None:
    with db.write() as session:
        add_fixture(session, CubeRow(id="C8", side_mm=400.0))
        days = (("x_up", NOON, date(2027, 1, 1)), ("x_up", LATER, date(2029, 1, 1)), ("y_up", LATER, None))
        for face, at, day in days:
            certify_faces(session, "C8", {face: FACE}, source="CMM", measured_utc=at, due_date=day)
        session.execute(text("UPDATE cubes SET due_date = NULL WHERE id = 'C8'"))  # as y_up, added last, had it
        session.execute(text(FIRST_DUE))
        session.expire_all()
        assert fixture_row(session, CubeRow, "C8").due_date == date(2029, 1, 1)
        assert fixture_row(session, CubeRow, "P1").due_date is None
        assert verify_dates(session) == []


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
