"""The effects of one's own in a database, held to what was stored."""

from sqlalchemy.orm import Session

from fixtures_db.user_effects import verify_effects
from station.errors import Altered


def check_stored(session: Session) -> None:
    """Raise `Altered` if an event of effects, of whatever unit, is not what was stored.

    Which effects are in force is then not known.
    """
    for fault in verify_effects(session):
        raise Altered(fault.row, fault.found, fault.expected, "restore the database from a copy")
