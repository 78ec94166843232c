"""Edits of what is declared, not of a value: the schema version, tables that take more or less, triggers."""

import random
import re

from sqlalchemy import Connection, Table, text

from fixtures_db.append_only_rows import append_only_tables, on_postgresql, on_sqlite
from fixtures_db.schema import Base

VERSION = {
    "emptied": "DELETE FROM alembic_version",
    "foreign": "UPDATE alembic_version SET version_num = 'a1b2c3d4'",
    "older": "UPDATE alembic_version SET version_num = '0007'",
    "doubled": "INSERT INTO alembic_version VALUES ('0003')",
}
REBUILT = {  # of SQLite's text of a table: what is replaced, once
    "NOT NULL taken away": (r" NOT NULL", ""),
    "type taken away": (r" (VARCHAR\(64\)|DOUBLE|DATE|INTEGER)(?=,| NOT)", ""),
    "compares without case": (r" VARCHAR\b(\(64\))?", r"\g<0> COLLATE NOCASE"),
    "refuses values": (r"\n\)", ",\n CHECK (1)\n)"),
    "may stand twice": (r",\s*CONSTRAINT \w+ UNIQUE \([^)]*\)", ""),
    "refers to nothing": (r",\s*CONSTRAINT \w+ FOREIGN KEY\([^)]*\) REFERENCES \w+ \(id\)", ""),
    "has a default": (r" (VARCHAR\(64\)|DOUBLE|DATE|VARCHAR) NOT NULL", r" \g<1> DEFAULT 0 NOT NULL"),
}
ALTERED = {  # of PostgreSQL
    "NOT NULL taken away": "ALTER TABLE {table} ALTER COLUMN {column} DROP NOT NULL",
    "another type": "ALTER TABLE {table} ALTER COLUMN {column} TYPE varchar(200) USING {column}::text",
    "has a default": "ALTER TABLE {table} ALTER COLUMN {column} SET DEFAULT NULL::text || '0'",
    "may stand twice": "ALTER TABLE {table} DROP CONSTRAINT {unique}",
    "refers to nothing": "ALTER TABLE {table} DROP CONSTRAINT {reference}",
    "refuses values": "ALTER TABLE {table} ADD CHECK (1 = 1)",
}
EITHER = {
    "a column added": "ALTER TABLE {table} ADD COLUMN more INTEGER",
    "an index added": "CREATE UNIQUE INDEX mine ON {table} (id)",
}


def edit_declaration(connection: Connection, chance: random.Random) -> str | None:
    """Do one of these; None where it cannot be done to the table drawn."""
    is_sqlite = connection.dialect.name == "sqlite"
    kind = chance.choice(("version", "either", "declared", "declared"))
    if kind == "version":
        how = chance.choice(list(VERSION))
        connection.execute(text(VERSION[how]))
        return f"schema version {how}"
    table = chance.choice(unreferenced())
    if kind == "declared" and is_sqlite:
        return rebuilt(connection, table, chance.choice(list(REBUILT)))
    statements = EITHER if kind == "either" else ALTERED
    how = chance.choice(list(statements))
    names = _names(table, chance)
    if any(name is None for key, name in names.items() if f"{{{key}}}" in statements[how]):
        return None
    connection.execute(text(statements[how].format(**names)))
    return f"{table.name}: {how}"


def _names(table: Table, chance: random.Random) -> dict[str, str | None]:
    columns = [one.name for one in table.columns if not one.nullable and one.type.python_type is str]
    columns = [one for one in columns if not table.c[one].primary_key]
    every = {key: [str(one.name) for one in table.constraints if type(one).__name__.startswith(kind)]
             for key, kind in (("unique", "Unique"), ("reference", "ForeignKey"))}  # fmt: skip
    return {
        "table": table.name,
        "column": chance.choice(columns) if columns else None,
        **{key: chance.choice(sorted(names)) if names else None for key, names in every.items()},
    }


def unreferenced() -> list[Table]:
    """Return the tables that no other names: they can be built anew without its knowledge."""
    named = {key.column.table.name for table in Base.metadata.tables.values() for key in table.foreign_keys}
    return [table for name, table in Base.metadata.tables.items() if name not in named]


def rebuilt(connection: Connection, table: Table, how: str) -> str | None:
    """Build a table of SQLite anew with all its rows, indices and triggers, and another declaration."""
    rows = connection.execute(text("SELECT type, sql FROM sqlite_master WHERE tbl_name = :t AND sql NOT NULL"),
                              {"t": table.name}).all()  # fmt: skip
    made = next(statement for kind, statement in rows if kind == "table")
    another = re.sub(*REBUILT[how], made, count=1)
    if another == made:
        return None
    connection.execute(text(another.replace(f"TABLE {table.name}", "TABLE built_anew", 1)))
    connection.execute(text(f"INSERT INTO built_anew SELECT * FROM {table.name}"))
    connection.execute(text(f"DROP TABLE {table.name}"))
    connection.execute(text(f"ALTER TABLE built_anew RENAME TO {table.name}"))
    for kind, statement in rows:
        if kind != "table":
            connection.exec_driver_sql(statement)
    return f"{table.name}: {how}"


def edit_trigger(connection: Connection, chance: random.Random) -> str:
    """Drop a trigger that keeps rows from being changed, weaken it, switch it off, or put another next to it."""
    table = chance.choice(append_only_tables())
    is_sqlite = connection.dialect.name == "sqlite"
    name, statement = chance.choice(list((on_sqlite if is_sqlite else on_postgresql)(table).items()))
    how = chance.choice(("drop", "weaken", "another", "off"))
    on_table = "" if is_sqlite else f" ON {table}"
    if how == "off" and not is_sqlite:
        connection.execute(text(f"ALTER TABLE {table} DISABLE TRIGGER {name}"))
        return f"{name} switched off"
    if how == "another":
        does = "BEGIN SELECT 1; END" if is_sqlite else "FOR EACH ROW EXECUTE FUNCTION refuse_change()"
        connection.execute(text(f"CREATE TRIGGER mine AFTER INSERT ON {chance.choice(('sites', table))} {does}"))
        return "a trigger added"
    connection.execute(text(f"DROP TRIGGER {name}{on_table}"))
    if how == "weaken":
        weaker = statement.replace("BEFORE", "AFTER", 1)
        if is_sqlite:
            weaker = re.sub(r"RAISE\(ABORT, '[^']*'\)", "RAISE(IGNORE)", statement)
        connection.execute(text(weaker))
    return f"{name}: {how}"
