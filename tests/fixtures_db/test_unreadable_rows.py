"""Of rows that cannot be read the first is named."""

from typing import Any

import pytest

from fixtures_db.database import Database
from fixtures_db.schema import Base, CalibrationRow, CampaignRow, CubeRow, SlabRow
from fixtures_db.unreadable_rows import NO_ROW, unreadable_row
from tests.fixtures_db.edited import edited

NO_DATE = "UPDATE campaigns SET started_utc = '{' WHERE id > 1"
NO_JSON = "UPDATE calibrations SET document = '{' WHERE id = 2"
NO_INPUTS = "UPDATE calibrations SET inputs = '{' WHERE id = 2"
EVERY = tuple(sorted((each.class_ for each in Base.registry.mappers), key=lambda row: row.__tablename__))


@pytest.mark.parametrize(
    ("statements", "tables", "row"),
    [
        ([], (CubeRow, SlabRow), "cubes or slabs"),
        ([], (SlabRow,), "slabs"),
        ([], EVERY, NO_ROW),
        ([], EVERY[1:], " or ".join(one.__tablename__ for one in EVERY[1:])),
        ([NO_DATE], (CampaignRow,), "campaigns 2"),
        ([NO_DATE], EVERY, "campaigns 2"),
        ([NO_DATE], (CalibrationRow, CubeRow), "calibrations or cubes"),
        ([NO_DATE, NO_JSON], (CubeRow, CampaignRow, CalibrationRow), "campaigns 2"),
        ([NO_DATE, NO_JSON], (CalibrationRow, CampaignRow), "calibrations 2"),
        ([NO_INPUTS], (CalibrationRow,), "calibrations 2"),
        (["UPDATE slabs SET due_date = 'x'"], (CubeRow, SlabRow), "slabs SLAB-1"),
    ],
)
def test_the_first_row_that_cannot_be_read_is_named_else_the_tables(
    rolled_back: Database, statements: list[str], tables: tuple[Any, ...], row: str
) -> None:
    with edited(rolled_back, *statements) as session:
        assert unreadable_row(session, tables) == row
