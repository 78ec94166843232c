"""Tables that were found as made are not looked at again, and those that are no longer so are found."""

from pathlib import Path

from sqlalchemy import text

from fixtures_db.database import open_db
from fixtures_db.declared_tables import declaration_faults


def test_a_table_declared_otherwise_after_a_check_is_found_by_the_next(tmp_path: Path) -> None:
    with open_db(tmp_path / "station.db") as database:
        for _ in "ab":
            with database.read() as session:
                assert declaration_faults(session.connection()) == []
        with database.engine.begin() as connection:
            connection.execute(text("ALTER TABLE imus ADD COLUMN colour TEXT"))
        with database.read() as session:
            [fault] = declaration_faults(session.connection())
    assert (fault.row, fault.expected) == ("table imus", "column colour none")
