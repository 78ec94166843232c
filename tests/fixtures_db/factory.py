"""A small solution with round numbers, and what a calibration says next to it."""

from datetime import UTC, date, datetime, time
from typing import Any

import numpy as np
from sqlalchemy import text
from sqlalchemy.orm import Session

from fixtures_db.append_only_rows import on_sqlite
from fixtures_db.campaigns import imu
from fixtures_db.fixture_measurements import add_level, add_measurement, certify_faces, drawing
from fixtures_db.fixtures import add_fixture
from fixtures_db.schema import CubeRow, SiteRow, SlabLevelRow, SlabRow
from fixtures_db.stored_calibrations import CalibrationFacts
from procedures.calibration.solution_values import Estimate, FitQuality, Solution, TriadCalibration
from procedures.campaign.campaign import FaceCertificate, MeasuredCube
from procedures.campaign.measured_cube import PARALLELISM, CubeMeasurement, UnitShare

NOON = datetime(2026, 3, 4, 12, 0, tzinfo=UTC)
LATER = datetime(2026, 6, 4, 12, 0, tzinfo=UTC)


def solution(bias: float = 1e-3) -> Solution:
    accelerometer = TriadCalibration(
        Estimate(np.array([1020.0, 1015.0, 1018.0]), np.full(3, 1e-3), "count/(g s)"),
        Estimate(np.eye(3), np.full((3, 3), 1e-6), "1"),
        Estimate(np.array([bias, 2e-3, 1e-3]), np.full(3, 8e-8), "g"),
    )
    return Solution(accelerometer, None, None, None, FitQuality(3.0, 3, 0.4), (), np.zeros((0, 0)), 23.0)


def facts(serial: str = "S1", until: date | None = None) -> CalibrationFacts:
    return CalibrationFacts(
        "FOG-3",
        serial,
        "fog-station 0.1.0",
        {"dwell_01.csv": "ab" * 32},
        accepted_utc=NOON,
        valid_from=NOON,
        valid_until=None if until is None else datetime.combine(until, time(), UTC),
    )


def fill_fixtures(session: Session) -> None:
    """Add a cube with drawing, certificates and measurements, a slab with levels, a site, and two IMUs."""
    face = FaceCertificate(np.array([1e-5, -2e-5]), np.array([[25e-12, 1e-12], [1e-12, 16e-12]]))
    add_fixture(session, CubeRow(id="CUBE-7", side_mm=400.0, tolerances=drawing({"t1": 0.02, "t8": 0.01})))
    certify_faces(session, "CUBE-7", {"x_up": face, "z_down": face}, source="CMM", measured_utc=NOON)
    due = date(2027, 3, 4)
    certify_faces(
        session, "CUBE-7", {"x_up": face}, source='CMM "2",\r\n \u00e9 # sha256 ', measured_utc=LATER, due_date=due
    )
    for at, moved in ((NOON, 0.0), (LATER, 5e-6)):
        given = {"measured_utc": at, "due_date": at.date().replace(year=2027)}
        add_measurement(
            session, "CUBE-7", measured_cube(moved), campaigns={"FOG-3 S1": {"day": "ab" * 32}}, **given
        )
    add_fixture(session, SlabRow(id="SLAB-1"))
    for at, east in ((NOON, 1e-5), (LATER, 3e-5)):
        due = at.date().replace(year=2027)
        tilt, std = (east, -1e-5), (5e-6, 5e-6)
        add_level(session, level_row("SLAB-1", tilt, std, source="level 17", measured_utc=at, due_date=due))
    survey = survey_columns(9.80665, 2e-6, "survey 12", date(2021, 5, 1), date(2026, 5, 1))
    add_fixture(session, SiteRow(id="SITE-1", latitude_deg=48.1, longitude_deg=11.5, height_m=520.0, **survey))
    imu(session, "FOG-3", "S1")
    imu(session, "FOG-3", "S2")


def level_row(
    slab_id: str, tilt: tuple[float, float] = (0.0, 0.0), std: tuple[float, float] = (1e-5, 1e-5), **reported: Any
) -> SlabLevelRow:
    """How a slab was found: east and north [rad]; ``reported`` has the columns that are not tilt and sigma."""
    (tilt_east_rad, tilt_north_rad), (std_east_rad, std_north_rad) = tilt, std
    return SlabLevelRow(
        slab_id=slab_id, tilt_east_rad=tilt_east_rad, tilt_north_rad=tilt_north_rad,
        std_east_rad=std_east_rad, std_north_rad=std_north_rad, **reported,
    )  # fmt: skip


def survey_columns(
    gravity: float, std: float, source: str, on: date | None = None, due_date: date | None = None
) -> dict[str, Any]:
    """What a site's columns are where its gravity was surveyed [m/s2]."""
    return {
        "gravity_m_s2": gravity, "gravity_std_m_s2": std, "gravity_source": source, "gravity_date": on,
        "due_date": due_date,
    }  # fmt: skip


def measured_cube(moved: float = 0.0, unit: str = "FOG-3 S1") -> CubeMeasurement:
    """A cube as one unit of K2 = 5e-5 g/g^2 measures it: y.x and z.x, less them by 2 K2 of x, and so on."""
    by_quadratic = np.array([[0, -2.0, 0], [0, 0, -2], [-2, 0, 0], [0, 0, -2], [-2, 0, 0], [0, -2, 0]])
    noise, value = 1e-14 * np.eye(6), np.arange(6) * 1e-5
    value[0] += moved
    cube = MeasuredCube(PARALLELISM, value, noise + 25e-10 * by_quadratic @ by_quadratic.T, (unit,))
    return CubeMeasurement(cube, noise, (UnitShare(unit, by_quadratic, 5e-5, np.full(3, 5e-5)),))


def protect_again(session: Session, table: str) -> None:
    """Put a table's triggers back, as whoever wants it unseen does."""
    if session.get_bind().dialect.name == "sqlite":
        for statement in on_sqlite(table).values():
            session.execute(text(statement))
    else:
        session.execute(text(f"ALTER TABLE {table} ENABLE TRIGGER USER"))


def unprotect(session: Session, table: str) -> None:
    """Drop a table's triggers, as whoever owns the database can."""
    if session.get_bind().dialect.name == "sqlite":
        named = text("SELECT name FROM sqlite_master WHERE type = 'trigger' AND tbl_name = :table")
        for trigger in session.scalars(named, {"table": table}).all():
            session.execute(text(f"DROP TRIGGER {trigger}"))
    else:
        session.execute(text(f"ALTER TABLE {table} DISABLE TRIGGER USER"))
