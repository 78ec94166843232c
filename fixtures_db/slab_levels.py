"""How level slabs were found over the years."""

from sqlalchemy.orm import Session

from fixtures_db.append_only_rows import append, date_owner
from fixtures_db.fixtures import fixture_row
from fixtures_db.schema import SlabLevelRow, SlabRow

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
