"""All that was recorded and calibrated, for whoever goes through the whole of it."""

from collections.abc import Sequence

from sqlalchemy import select
from sqlalchemy.orm import Session

from fixtures_db.schema import CalibrationRow, CampaignRow

COMPLETE_STATES = ("recorded", "accepted")


def complete_campaigns(session: Session) -> Sequence[CampaignRow]:
    """Return the campaigns whose recording was completed, oldest first."""
    rows = select(CampaignRow).where(CampaignRow.state.in_(COMPLETE_STATES))
    return session.scalars(rows.order_by(CampaignRow.started_utc, CampaignRow.id)).all()


def newest_calibration(session: Session, folder: str) -> CalibrationRow | None:
    """Return the newest calibration stored from the campaign of a folder, None if there is none."""
    rows = select(CalibrationRow).join(CampaignRow).where(CampaignRow.folder == folder)
    return session.scalars(rows.order_by(CalibrationRow.id.desc()).limit(1)).first()
