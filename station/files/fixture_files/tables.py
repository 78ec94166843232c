"""The tables of ``fixtures/1``, made from the database's: a key is a column, with its type and unit.

The dates of a cube or a slab with certificates or levels are those of the last one.
"""

from datetime import UTC, datetime
from typing import Annotated, Any

from pydantic import AfterValidator, BaseModel, ConfigDict, create_model

from fixtures_db.fixture_transfer import CARRIED_TABLES, CarriedTable, Rows
from fixtures_db.schema import UtcDateTime
from station.files.text_fields import unseen


def _aware(moment: datetime) -> datetime:
    if moment.tzinfo is None:
        raise ValueError("a moment with its time zone, such as 2026-03-04T12:00:00Z")
    return moment.astimezone(UTC)


def _without_controls(text: str) -> str:
    if found := unseen(text.translate({ord(each): None for each in "\r\n\t"})):  # a source may have several lines
        raise ValueError(f"printable characters, not {found[:60]}")
    return text


Moment = Annotated[datetime, AfterValidator(_aware)]
DEFAULTS = {"covariance_12_rad2": 0.0}  # of a column that always has a value


class FixturesTable(BaseModel):
    """A table of the file."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, coerce_numbers_to_str=True)


class FixturesFile(FixturesTable):
    """The whole of a ``fixtures/1``."""

    format: str = "fixtures/1"

    @property
    def rows(self) -> Rows:
        """The rows by table, as `fixtures_db.fixture_transfer.restore` takes them."""
        return {name: [row.model_dump() for row in getattr(self, name)] for name in TABLES}


def _model(table: CarriedTable) -> type[BaseModel]:
    fields: dict[str, Any] = {}
    for name in table.columns:
        column = table.row.__table__.columns[name]
        kind = Moment if isinstance(column.type, UtcDateTime) else column.type.python_type
        if kind is str:
            kind = Annotated[str, AfterValidator(_without_controls)]
        fields[name] = (kind | None, None) if column.nullable else (kind, DEFAULTS.get(name, ...))
    return create_model(table.name, __base__=FixturesTable, **fields)


TABLES = {table.name: _model(table) for table in CARRIED_TABLES}
_LISTS: dict[str, Any] = {name: (list[model], []) for name, model in TABLES.items()}  # type: ignore[valid-type]
FIXTURES_FILE = create_model("FixturesFile", __base__=FixturesFile, **_LISTS)
