"""The tables of an empty SQLite database are migrated once a process, and then made as they came out."""

from collections.abc import Callable, Iterator

import pytest
from sqlalchemy import Connection


def remembering(upgrade: Callable[[Connection], None]) -> Callable[[Connection], None]:
    """Return ``upgrade``, which says the statements of its first result again wherever no table is."""
    known = list[str]()

    def upgraded(connection: Connection) -> None:
        if connection.dialect.name != "sqlite" or _statements(connection):
            upgrade(connection)
        elif known:
            for each in known:
                connection.exec_driver_sql(each)
        else:
            upgrade(connection)
            known.extend(_statements(connection))

    return upgraded


def _statements(connection: Connection) -> list[str]:
    """Return what makes the tables, their rows, and then their indices and triggers."""
    every = connection.connection.dbapi_connection.iterdump()  # type: ignore[union-attr]
    return [each for each in every if each not in {"BEGIN TRANSACTION;", "COMMIT;"}]


@pytest.fixture(scope="session", autouse=True)
def schema_is_made_once() -> Iterator[None]:
    """The migrations have tests of their own, tests/fixtures_db."""
    from fixtures_db.migrations import upgrade

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(upgrade, "upgrade", remembering(upgrade.upgrade))
        yield
