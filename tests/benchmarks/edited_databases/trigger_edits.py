"""Edits of the triggers that keep rows from being changed: dropped, weakened, switched off, others beside them."""

import random
import re

from sqlalchemy import Connection, text

from fixtures_db.append_only_rows import append_only_tables, on_postgresql, on_sqlite


def edit_trigger(connection: Connection, chance: random.Random) -> str:
    """Do one of these to a trigger."""
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
