"""What was measured of fixtures, each measurement appended and chained, and the cube as a solve takes it.

Certificates of a cube's resting faces; cubes as IMUs measured them, used where the faces have no certificate; how
level slabs were found over the years; and the tolerance items of a cube's drawing (Yao, Hu, He 2018, table 2).

`dump` and `restore` carry all fixtures as plain rows from one database into another. What is chained keeps its
order: taken into an empty database it gives the same hashes. What a database has already is left as it is; what
would change it is refused.
"""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from datetime import date, datetime
from typing import Any

import numpy as np
from sqlalchemy import select
from sqlalchemy.orm import Session

from fixtures_db.append_only_rows import ROW_TITLES, append, date_owner, in_force
from fixtures_db.errors import DiffersFromStored, NotInDatabase
from fixtures_db.fixtures import check_site, fixture_row
from fixtures_db.schema import (
    CubeMeasurementRow,
    CubeRow,
    FaceCertificateRow,
    ImuRow,
    SiteRow,
    SlabLevelRow,
    SlabRow,
    ToleranceRow,
)
from procedures.arrays import FloatArray
from procedures.campaign.campaign import FaceCertificate, Fixture, MeasuredCube
from procedures.campaign.measured_cube import NAMES, CubeMeasurement, UnitShare
from procedures.positions import FACES
from procedures.tolerance.drawing_items import DRAWING_ITEMS

MAX_TILT_RAD = 0.1  # beyond it a tilt is a slip of the pen


def add_level(session: Session, row: SlabLevelRow) -> SlabLevelRow:
    """Append how a slab was found; what was measured earlier stays.

    The tilt is as `solve` gives its ``slab.tilt``: the up vector's components seen from the slab.
    """
    slab = fixture_row(session, SlabRow, row.slab_id)
    check_level(row)
    append(session, row)
    date_owner(session, slab)
    return row


def check_level(row: SlabLevelRow) -> None:
    """Raise `ValueError` if a row is no level of a slab."""
    for tilt, std in ((row.tilt_east_rad, row.std_east_rad), (row.tilt_north_rad, row.std_north_rad)):
        if not (abs(tilt) < MAX_TILT_RAD and 0 < std < MAX_TILT_RAD):
            raise ValueError(
                f"level of slab {row.slab_id!r} is {tilt} +- {std} rad, "
                f"expected a tilt under {MAX_TILT_RAD} rad and its 1 sigma above 0"
            )


def add_measurement(
    session: Session,
    cube_id: str,
    measured: CubeMeasurement,
    *,
    campaigns: Mapping[str, Mapping[str, str]],
    measured_utc: datetime,
    due_date: date | None = None,
) -> CubeMeasurementRow:
    """Append a measurement of a cube; those before it stay.

    ``campaigns`` holds by unit, model and serial number, the SHA-256 of each campaign by its folder's name.
    """
    cube = fixture_row(session, CubeRow, cube_id)
    sources = [
        {
            "unit": share.unit,
            "campaigns": dict(campaigns[share.unit]),
            "by_quadratic": share.by_quadratic.tolist(),
            "quadratic_std": share.quadratic_std,
            "quadratic_left": share.quadratic_left.tolist(),
        }
        for share in measured.shares
    ]
    row = CubeMeasurementRow(
        cube_id=cube_id,
        values_rad=_text(dict(zip(measured.cube.names, measured.cube.value.tolist(), strict=True))),
        covariance_rad2=_text(measured.cube.covariance.tolist()),
        sources=_text(sources),
        measured_utc=measured_utc,
        due_date=due_date,
    )
    check_measurement(row)
    append(session, row)
    date_owner(session, cube)
    return row


def measurements(cube: CubeRow) -> Sequence[CubeMeasurementRow]:
    """Return a cube's measurements, the earliest first."""
    return sorted(cube.measurements, key=lambda row: (row.measured_utc, row.id))


def measurement(row: CubeMeasurementRow) -> CubeMeasurement:
    """Return a row as it was measured; raise `ValueError` if it is no measurement."""
    try:
        values, covariance, sources = (json.loads(t) for t in (row.values_rad, row.covariance_rad2, row.sources))
        names, value = tuple(values), np.array(list(values.values()), dtype=float)
        shares = tuple(_share(source, len(names)) for source in sources)
        units = tuple(share.unit for share in shares)
        cube = MeasuredCube(names, value, np.array(covariance, dtype=float), units)
        quadratic = (s.quadratic_std**2 * s.by_quadratic @ s.by_quadratic.T for s in shares)
        return CubeMeasurement(cube, cube.covariance - sum(quadratic, np.zeros(cube.covariance.shape)), shares)
    except (TypeError, KeyError, AttributeError, ValueError) as error:
        raise ValueError(f"measurement of cube {row.cube_id!r}: {error}") from error


def check_measurement(row: CubeMeasurementRow) -> None:
    """Raise `ValueError` if a row is no measurement of a cube."""
    cube, name = measurement(row).cube, f"measurement of cube {row.cube_id!r}"
    n, C = len(cube.names), cube.covariance
    if not n or not set(cube.names) <= set(NAMES):
        raise ValueError(f"{name}: values {', '.join(cube.names)}, expected of {', '.join(NAMES)}")
    if not np.all(np.abs(cube.value) < MAX_TILT_RAD):
        raise ValueError(f"{name}: values {cube.value.tolist()} rad, expected each under {MAX_TILT_RAD} rad")
    if C.shape != (n, n) or not np.allclose(C, C.T, rtol=1e-9, atol=0) or not np.linalg.eigvalsh(C)[0] > 0:
        raise ValueError(f"{name}: covariance, expected symmetric ({n}, {n}), positive definite")


def _share(source: Mapping[str, Any], n: int) -> UnitShare:
    left, by = (np.array(source[key], dtype=float) for key in ("quadratic_left", "by_quadratic"))
    if by.shape != (n, 3) or left.shape != (3,):
        raise ValueError(f"by_quadratic is {by.shape} and quadratic_left {left.shape}, expected ({n}, 3) and (3,)")
    return UnitShare(str(source["unit"]), by, float(source["quadratic_std"]), left)


def _text(value: object) -> str:
    # the order of the values is that of the covariance: keys are not sorted
    return json.dumps(value, allow_nan=False, ensure_ascii=False, separators=(",", ":"))


def certify_faces(
    session: Session,
    cube_id: str,
    faces: Mapping[str, FaceCertificate],
    *,
    source: str,
    measured_utc: datetime,
    due_date: date | None = None,
) -> None:
    """Append a certificate of some or all faces of a cube; those measured earlier stay and are no longer used.

    ``faces`` by resting face (``x_up`` ...): up vector's components (2,) [rad] along the two other cube axes
    and their covariance (2, 2) [rad2]. ``source`` says who measured, and how.
    """
    cube = fixture_row(session, CubeRow, cube_id)
    for resting, face in faces.items():
        row = FaceCertificateRow(
            cube_id=cube_id,
            resting=resting,
            source=source,
            measured_utc=measured_utc,
            due_date=due_date,
            **_columns(face),
        )
        check_certificate(row)
        append(session, row)
    date_owner(session, cube)


def cube(session: Session, cube_id: str, C_sb: FloatArray | None = None) -> Fixture:
    """Return the fixture a solve takes: of each face what was measured last, none where it never was.

    Where no face was, it holds what IMUs measured of the cube last. ``C_sb`` (3, 3), a rotation, takes the cube's
    axes to the IMU's; identity if not given.
    """
    row = fixture_row(session, CubeRow, cube_id)
    faces = {resting: face_certificate(face) for resting, face in faces_in_force(row).items()}
    last = None if faces else in_force(row.measurements)
    measured = None if last is None else measurement(last).cube
    return Fixture(faces, np.eye(3) if C_sb is None else C_sb, cube_id, measured)


def faces_in_force(cube: CubeRow) -> dict[str, FaceCertificateRow]:
    """Return by resting face what was measured last, in the order of `FACES`."""
    by_face = {resting: [row for row in cube.certificates if row.resting == resting] for resting in FACES}
    return {resting: row for resting, rows in by_face.items() if (row := in_force(rows)) is not None}


def check_certificate(row: FaceCertificateRow) -> None:
    """Raise `ValueError` if a row is no certificate of a face."""
    if row.resting not in FACES:
        raise ValueError(f"face {row.resting!r} is none of {', '.join(FACES)}")
    _columns(face_certificate(row))


def _columns(face: FaceCertificate) -> dict[str, float]:
    covariance = np.asarray(face.covariance, dtype=float)
    if (
        covariance.shape != (2, 2)
        or not np.allclose(covariance, covariance.T)
        or np.linalg.eigvalsh(covariance)[0] < 0
    ):
        raise ValueError(
            f"covariance of a face is {covariance.tolist()}, expected symmetric (2, 2), none negative"
        )
    if not np.all(np.abs(face.up_tilt) < MAX_TILT_RAD):
        raise ValueError(f"tilt of a face is {face.up_tilt} rad, expected each under {MAX_TILT_RAD} rad")
    return {
        "up_tilt_1_rad": float(face.up_tilt[0]),
        "up_tilt_2_rad": float(face.up_tilt[1]),
        "covariance_11_rad2": float(covariance[0, 0]),
        "covariance_12_rad2": float(covariance[0, 1]),
        "covariance_22_rad2": float(covariance[1, 1]),
    }


def face_certificate(row: FaceCertificateRow) -> FaceCertificate:
    """Return a row as a solve takes it."""
    covariance = [
        [row.covariance_11_rad2, row.covariance_12_rad2],
        [row.covariance_12_rad2, row.covariance_22_rad2],
    ]
    return FaceCertificate(np.array([row.up_tilt_1_rad, row.up_tilt_2_rad]), np.array(covariance))


def drawing(tolerances_mm: Mapping[str, float]) -> list[ToleranceRow]:
    """Return the items of a drawing by their names in the table; raise `ValueError` for one that is not there."""
    for item, value in tolerances_mm.items():
        if item not in DRAWING_ITEMS:
            raise ValueError(f"tolerance item {item!r} is none of {', '.join(DRAWING_ITEMS)}")
        if not value > 0:
            raise ValueError(f"tolerance {item} is {value} mm, expected more than 0")
    return [
        ToleranceRow(item=item, kind=kind, face=face, reference_face=reference, tolerance_mm=tolerances_mm[item])
        for item, (kind, face, reference) in DRAWING_ITEMS.items()
        if item in tolerances_mm
    ]


Value = str | float | date | datetime | None
Rows = Mapping[str, Sequence[Mapping[str, Value]]]
DERIVED_DATES = frozenset({"certificate_date", "due_date"})
DATED_BY: dict[type[Any], tuple[str, ...]] = {  # their dates follow from these
    CubeRow: ("certificate", "measurement"),
    SlabRow: ("level",),
}


@dataclass(frozen=True, slots=True)
class CarriedTable:
    """A table that is carried over: ``key`` names a row, ``check`` refuses what is none."""

    name: str
    row: type[Any]
    key: tuple[str, ...]
    check: Callable[[Any], None] = lambda row: None

    @property
    def columns(self) -> tuple[str, ...]:
        """The columns that are carried over: no number of a row, no hash."""
        made = {"previous", "sha256"} | ({"id"} - set(self.key))
        return tuple(column.key for column in self.row.__table__.columns if column.key not in made)


CARRIED_TABLES = (  # what a row names stands before it
    CarriedTable("cube", CubeRow, ("id",)),
    CarriedTable("tolerance", ToleranceRow, ("cube_id", "item")),
    CarriedTable(
        "certificate", FaceCertificateRow, ("cube_id", "resting", "measured_utc", "source"), check_certificate
    ),
    CarriedTable("measurement", CubeMeasurementRow, ("cube_id", "measured_utc", "sources"), check_measurement),
    CarriedTable("slab", SlabRow, ("id",)),
    CarriedTable("level", SlabLevelRow, ("slab_id", "measured_utc", "source"), check_level),
    CarriedTable("site", SiteRow, ("id",), check_site),
    CarriedTable("imu", ImuRow, ("model", "serial")),
)


def dump(session: Session) -> dict[str, list[dict[str, Value]]]:
    """Return every fixture by table, each row as its columns, in the order in which it was added."""
    return {
        table.name: [_values(table, row) for row in session.scalars(select(table.row).order_by(table.row.id))]
        for table in CARRIED_TABLES
    }


def restore(session: Session, rows: Rows) -> dict[str, int]:
    """Add rows, as `dump` gives them, to what is there; return how many of each table were new.

    Raises
    ------
    DiffersFromStored
        If a row of that name is there with other values.
    NotInDatabase
        If a row names a cube or slab that is neither there nor in ``rows``.
    ValueError
        If a row is none of its kind.
    """
    added = {
        table.name: sum(_add(session, table, row, rows) for row in rows.get(table.name, ()))
        for table in CARRIED_TABLES
    }
    for owner in DATED_BY:
        for row in session.scalars(select(owner)).all():
            date_owner(session, row)
    return added


def _add(session: Session, table: CarriedTable, values: Mapping[str, Value], rows: Rows) -> bool:
    name = " ".join(str(values[key]) for key in table.key)
    key = [getattr(table.row, key) == values[key] for key in table.key]
    stored = session.scalars(select(table.row).where(*key)).first()
    if stored is not None:
        follows = DERIVED_DATES if any(rows.get(of) for of in DATED_BY.get(table.row, ())) else frozenset()
        for column, found in _values(table, stored).items():
            if column not in follows and found != values[column]:
                raise DiffersFromStored(table.name, name, column, values[column], found)
        return False
    row = table.row(**values)
    table.check(row)
    _refuse_orphan(session, values)
    if table.row in ROW_TITLES:
        append(session, row)
    else:
        session.add(row)
        session.flush()
    return True


def _refuse_orphan(session: Session, values: Mapping[str, Value]) -> None:
    for kind, owner in (("cube", CubeRow), ("slab", SlabRow)):
        name = values.get(f"{kind}_id")
        if name is not None and session.get(owner, name) is None:
            raise NotInDatabase(kind, str(name), session.scalars(select(owner.id).order_by(owner.id)).all())


def _values(table: CarriedTable, row: Any) -> dict[str, Value]:
    return {column: getattr(row, column) for column in table.columns}
