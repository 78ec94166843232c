"""Triggers that refuse to change or delete rows of a chained table, and whether they are all there as made."""

from sqlalchemy import Connection, text

from fixtures_db.hash_chain import ChainFault
from fixtures_db.schema import Base

REFUSING_FUNCTION = "BEGIN RAISE EXCEPTION '% is append-only', TG_TABLE_NAME; END"
_ON_POSTGRESQL = """
SELECT t.tgname, replace(pg_get_triggerdef(t.oid, true), quote_ident(current_schema()) || '.', ''),
       t.tgenabled, btrim(p.prosrc)
FROM pg_trigger t JOIN pg_class c ON c.oid = t.tgrelid JOIN pg_proc p ON p.oid = t.tgfoid
WHERE NOT t.tgisinternal AND c.relnamespace = current_schema()::regnamespace
UNION ALL SELECT rulename, 'rule', 'O', '' FROM pg_rules WHERE schemaname = current_schema()
"""


def append_only_tables() -> tuple[str, ...]:
    """Return the tables whose rows are chained."""
    return tuple(name for name, table in Base.metadata.tables.items() if "previous" in table.columns)


def on_sqlite(table: str) -> dict[str, str]:
    """Return the statements of a table's triggers by name."""
    refuse = f"BEGIN SELECT RAISE(ABORT, '{table} is append-only'); END"
    # INSERT OR REPLACE deletes without firing a DELETE trigger
    is_there = "id = NEW.id OR previous = NEW.previous OR sha256 = NEW.sha256"
    moments = {
        f"{table}_no_update": "UPDATE ON {}",
        f"{table}_no_delete": "DELETE ON {}",
        f"{table}_no_replace": f"INSERT ON {{}} WHEN EXISTS (SELECT 1 FROM {{}} WHERE {is_there})",
    }
    return {
        name: f"CREATE TRIGGER {name} BEFORE {moment.replace('{}', table)} {refuse}"
        for name, moment in moments.items()
    }


def on_postgresql(table: str) -> dict[str, str]:
    """Return the statements of a table's triggers by name; they call ``refuse_change``."""
    return {
        f"{table}_no_{action.lower()}": f"CREATE TRIGGER {table}_no_{action.lower()} BEFORE {action} ON {table} "
        f"FOR EACH STATEMENT EXECUTE FUNCTION refuse_change()"
        for action in ("UPDATE", "DELETE", "TRUNCATE")  # ON CONFLICT DO UPDATE fires the one of UPDATE
    }


def trigger_faults(connection: Connection) -> list[ChainFault]:
    """Return every trigger that lacks, is switched off, does something else or was added by others."""
    is_sqlite = connection.dialect.name == "sqlite"
    made = on_sqlite if is_sqlite else on_postgresql
    expected = {name: sql for table in append_only_tables() for name, sql in made(table).items()}
    found = _on_sqlite_now(connection) if is_sqlite else _on_postgresql_now(connection)
    return [
        ChainFault(f"trigger {name}", found.get(name, "none"), expected.get(name, "none"))
        for name in sorted(expected.keys() | found.keys())
        if found.get(name) != expected.get(name)
    ]


def _on_sqlite_now(connection: Connection) -> dict[str, str]:
    rows = connection.execute(text("SELECT name, sql FROM sqlite_master WHERE type = 'trigger'"))
    return {row.name: row.sql for row in rows}


def _on_postgresql_now(connection: Connection) -> dict[str, str]:
    return {
        name: f"{statement}{'' if state in {'O', 'A'} else ', disabled'}"
        f"{'' if source == REFUSING_FUNCTION else f', which runs {source}'}"
        for name, statement, state, source in connection.execute(text(_ON_POSTGRESQL))
    }
