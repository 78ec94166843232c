"""Edits by somebody who knows the hashes: a row's chain, and the journal, made to fit from there to the end."""

import json
import random
from contextlib import suppress
from datetime import datetime
from typing import Any

from sqlalchemy import Column, Connection, Table, select
from sqlalchemy.orm import Session

from fixtures_db.append_only_rows import ROW_TITLES, row_text
from fixtures_db.campaigns import manifest_head
from fixtures_db.hash_chain import GENESIS, canonical, digest
from fixtures_db.journal import DELETE, contents, entry_text, journalled_tables
from fixtures_db.schema import Base, CalibrationRow, CampaignRow, UtcDateTime
from tests.benchmarks.edited_databases import row_edits

JOURNAL = Base.metadata.tables["journal"]
BY_HASH = frozenset({"id", "previous", "sha256", "manifest_sha256"})  # these follow from the others


def rewrite(connection: Connection, table: Table, column: Column[Any], chance: random.Random) -> str | None:
    """Change a value, then every hash that follows from it: of its own chain and of the journal."""
    if table is JOURNAL or column.key in BY_HASH or column.primary_key:
        return None
    if (edit := row_edits.make_edit("change", connection, table, column, chance)) is None:
        return None
    fit_chains(connection)
    fit_journal(connection)
    return f"{edit}, all hashes made to fit"


def cut(connection: Connection, chance: random.Random) -> str:
    """Take the newest entries of the journal back, and the rows with them: the state of an earlier day."""
    rows = row_edits.rows_of(connection, JOURNAL)
    kept = rows[: chance.randrange(len(rows) // 2, len(rows))]
    state = dict[tuple[str, str], str]()
    for row in kept:
        state[row["table_name"], row["row_key"]] = row["content"] if row["event"] != DELETE else ""
    connection.execute(JOURNAL.delete().where(JOURNAL.c.id > len(kept)))
    for table in reversed(journalled_tables()):
        for key, content in list(contents(connection, table)):
            if (then := state.get((table.name, key), "")) != content:
                _back(connection, table, key, then)
    return f"journal cut to {len(kept)} of {len(rows)} entries, the rows with it"


def fit_chains(connection: Connection) -> None:
    """Hash every chained row again where its text has changed, and each that follows."""
    with Session(bind=connection) as session:
        for table in ROW_TITLES:
            head, is_other = GENESIS, False
            for row in session.scalars(select(table).order_by(table.id)).all():
                is_other |= row.previous != head or digest(row_text(row)) != row.sha256
                if is_other:
                    row.previous = head
                    if isinstance(row, CalibrationRow) and row.document.startswith("{"):
                        with suppress(ValueError):  # no JSON any more: it stays as it is
                            row.document = canonical(json.loads(row.document) | {"previous": head})
                    row.sha256 = digest(row_text(row))
                head = row.sha256
        for campaign in session.scalars(select(CampaignRow)):
            campaign.manifest_sha256 = manifest_head(campaign.steps)
        session.flush()


def fit_journal(connection: Connection) -> None:
    """Let the last entry of each row say what the row now is, and hash the journal again from there."""
    rows = row_edits.rows_of(connection, JOURNAL)
    last = {(row["table_name"], row["row_key"]): row for row in rows}
    changed = len(rows)
    for table in journalled_tables():
        for key, content in contents(connection, table):
            entry = last.get((table.name, key))
            if entry is not None and entry["content"] != content:
                entry["content"] = content
                changed = min(changed, entry["id"] - 1)
    head = rows[changed - 1]["sha256"] if changed else GENESIS
    for row in reversed(rows[changed:]):  # a hash may stand once: they make room from the newest on
        connection.execute(JOURNAL.update().where(JOURNAL.c.id == row["id"])
                           .values(previous=f"p{row['id']}", sha256=f"s{row['id']}"))  # fmt: skip
    for row in rows[changed:]:
        row["previous"] = head
        row["sha256"] = head = digest(entry_text(row))
        connection.execute(JOURNAL.update().where(JOURNAL.c.id == row["id"]).values(row))


def _back(connection: Connection, table: Table, key: str, then: str) -> None:
    """Give a row what it held, as far as its content says; a row that was not there goes."""
    column = next(iter(table.primary_key))
    where = column == column.type.python_type(key)
    if not then:
        connection.execute(table.delete().where(where))
        return
    stored = json.loads(then)
    values = {each.key: _value(each, stored.get(each.key)) for each in table.columns
              if not str(stored.get(each.key, "")).startswith("sha256 ")}  # fmt: skip
    connection.execute(table.update().where(where).values(values))


def _value(column: Column[Any], stored: Any) -> Any:
    kind = datetime if isinstance(column.type, UtcDateTime) else column.type.python_type
    return kind.fromisoformat(stored) if isinstance(stored, str) and hasattr(kind, "fromisoformat") else stored
