"""The tables of an empty database are migrated once a process, and then made as they came out."""

from collections.abc import Callable, Iterator
from typing import Any

import pytest
from sqlalchemy import Connection, event, text

from tests.computed_once import look_anew

Statement = tuple[str, Any]  # with its parameters


def remembering(upgrade: Callable[[Connection], None]) -> Callable[[Connection], None]:
    """Return ``upgrade``, which says the statements of its first result again wherever no table is."""
    known = dict[str, list[Statement]]()

    def upgraded(connection: Connection) -> None:
        kind = connection.dialect.name
        if not _is_empty(connection):
            upgrade(connection)
        elif kind in known:
            for statement, parameters in known[kind]:
                connection.exec_driver_sql(statement, parameters)
        else:
            told = _told(connection, upgrade)
            known[kind] = [(each, None) for each in _dumped(connection)] if kind == "sqlite" else told

    return upgraded


def _is_empty(connection: Connection) -> bool:
    if connection.dialect.name == "sqlite":
        return not _dumped(connection)
    here = "SELECT count(*) FROM information_schema.tables WHERE table_schema = current_schema()"
    return connection.execute(text(here)).scalar() == 0


def _told(connection: Connection, upgrade: Callable[[Connection], None]) -> list[Statement]:
    """Upgrade; return what that said to the server but questions."""
    told = list[Statement]()

    def hear(_connection: object, _cursor: object, statement: str, parameters: Any, *_: object) -> None:
        if not statement.lstrip().upper().startswith("SELECT"):
            told.append((statement, parameters))

    event.listen(connection, "before_cursor_execute", hear)
    try:
        upgrade(connection)
    finally:
        event.remove(connection, "before_cursor_execute", hear)
    return told


def _dumped(connection: Connection) -> list[str]:
    """Return what makes SQLite's tables, their rows, and then their indices and triggers."""
    every = connection.connection.dbapi_connection.iterdump()  # type: ignore[union-attr]
    return [each for each in every if each not in {"BEGIN TRANSACTION;", "COMMIT;"}]


@pytest.fixture(scope="session", autouse=True)
def schema_is_made_once() -> Iterator[None]:
    """The migrations have tests of their own, tests/fixtures_db."""
    from fixtures_db.migrations import upgrade

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(upgrade, "upgrade", remembering(upgrade.upgrade))
        look_anew()
        yield
