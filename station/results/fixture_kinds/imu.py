"""An IMU as it is shown: how many calibrations it has."""

from sqlalchemy import select
from sqlalchemy.orm import Session

from fixtures_db.errors import NotInDatabase
from fixtures_db.schema import ImuRow
from fixtures_db.stored_calibrations import history
from station.text import plural


def lines(session: Session) -> list[str]:
    """Return a line for each IMU."""
    return [f"{row.model} {row.serial}: {_calibrations(session, row)}" for row in _rows(session)]


def description(session: Session, name: str) -> str:
    """Return the IMUs of a serial number; raise `NotInDatabase` if there is none."""
    if not (found := [row for row in _rows(session) if row.serial == name]):
        raise NotInDatabase("IMU", name, [row.serial for row in _rows(session)])
    return "\n".join(f"{row.model} {row.serial}: {_calibrations(session, row)}" for row in found)


def _rows(session: Session) -> list[ImuRow]:
    return list(session.scalars(select(ImuRow).order_by(ImuRow.model, ImuRow.serial)))


def _calibrations(session: Session, row: ImuRow) -> str:
    own = [stored for stored in history(session, row.serial) if stored.imu_id == row.id]
    if not own:
        return "no calibration"
    return f"{plural(len(own), 'calibration')}, the last of {own[-1].accepted_utc:%Y-%m-%d}"
