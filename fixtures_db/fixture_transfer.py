"""All fixtures as plain rows, from one database into another.

What is chained keeps its order: taken into an empty database it gives the same hashes. What a database has already
is left as it is; what would change it is refused.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from datetime import date, datetime
from typing import Any

from sqlalchemy import select
from sqlalchemy.orm import Session

from fixtures_db.append_only_rows import ROW_TITLES, append, date_owner
from fixtures_db.errors import DiffersFromStored, NotInDatabase
from fixtures_db.fixture_measurements import check_certificate, check_level, check_measurement
from fixtures_db.fixtures import check_site
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
