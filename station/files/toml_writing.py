"""Values, tables and arrays of tables as TOML text."""

import json
from collections.abc import Mapping
from datetime import date, datetime

from fixtures_db.calibration import utc_text


def toml_text(tables: Mapping[str, object]) -> str:
    """Return nested tables as TOML; a key without a value is left out."""
    lines = list[str]()
    _write_table((), tables, lines)
    return "\n".join(lines).strip("\n") + "\n"


def _write_table(path: tuple[str, ...], table: Mapping[str, object], lines: list[str]) -> None:
    tables = {k: v for k, v in table.items() if isinstance(v, Mapping) or _is_tables(v)}
    lines += [
        f"{key} = {toml_value(value)}" for key, value in table.items() if not (value is None or key in tables)
    ]
    for key, value in tables.items():
        name = ".".join((*path, key))
        if isinstance(value, Mapping):
            lines += ["", f"[{name}]"]
            _write_table((*path, key), value, lines)
        elif isinstance(value, list):
            for item in value:
                lines += ["", f"[[{name}]]"]
                _write_table((*path, key), item, lines)


def _is_tables(value: object) -> bool:
    return isinstance(value, list) and all(isinstance(item, Mapping) for item in value)


def toml_value(value: object) -> str:
    """Return a text, number or moment, or a list of these, as TOML."""
    if isinstance(value, str):  # JSON's escapes are TOML's, but for DEL
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, list):
        return f"[{', '.join(toml_value(item) for item in value)}]"
    if isinstance(value, datetime):
        return utc_text(value)
    if isinstance(value, date):
        return value.isoformat()
    if isinstance(value, int | float):
        return repr(value)
    raise TypeError(f"{value!r} has no place in a TOML file")
