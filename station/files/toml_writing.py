"""Values, tables and arrays of tables as TOML text."""

import json
from collections.abc import Iterator, Mapping
from datetime import date, datetime
from typing import Any

from fixtures_db.calibration import utc_text


def toml_text(tables: Mapping[str, object]) -> str:
    """Return nested tables as TOML; a key without a value is left out."""
    return "\n".join(_lines((), tables)).strip("\n") + "\n"


def _lines(path: tuple[str, ...], table: Mapping[str, object]) -> Iterator[str]:
    tables: dict[str, Any] = {k: v for k, v in table.items() if isinstance(v, Mapping) or _is_tables(v)}
    for key, value in table.items():
        if not (value is None or key in tables):
            yield f"{key} = {toml_value(value)}"
    for key, value in tables.items():
        name, own = ".".join((*path, key)), isinstance(value, Mapping)
        for item in [value] if own else value:
            yield from ("", f"[{name}]" if own else f"[[{name}]]", *_lines((*path, key), item))


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
