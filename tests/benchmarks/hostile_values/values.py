"""What is put in the place of a value, where in parsed TOML it can be put, and any value as TOML."""

import copy
import json
from collections.abc import Iterator
from datetime import UTC, date, datetime
from typing import Any

Place = tuple[str | int, ...]

NUMBERS: tuple[Any, ...] = (
    0, -1, 1, 10**20, -(10**20), 2**63, 2**31, 99, 0.0, -0.0, 5e-324, 1e-308, 1e-15, 1e15, 1e308, -1e308,
    float("nan"), float("inf"), True,
)  # fmt: skip
WORDS: tuple[Any, ...] = (
    "", " ", "nan", "1e3", "a\x00b", "\x1b[31mred", "a\nb", "\u202egnp.exe", "\u200b", "../../x", "/etc/passwd",
    "..", "C:\\x", "x" * 200, "x" * 1_000_000, "<script>alert(1)</script>", "&amp;]]>", "%s%n{0}", "\u0301" * 40,
    "ÄÖ 測定", "😀", "a;b,c", "=1+1",
)  # fmt: skip
SHAPES: tuple[Any, ...] = (
    [], {}, [[]], [1, "a"], {"a": 1}, [[1.0, 2.0], [3.0]], [{}], [0.0] * 7, date(2026, 1, 1),
    datetime(1, 1, 1, tzinfo=UTC), [[[[[[[[1]]]]]]]],
)  # fmt: skip
VALUES = NUMBERS + WORDS + SHAPES
LEFT_OUT = object()


def places(table: Any, at: Place = ()) -> Iterator[Place]:
    """Yield the path of every value in a parsed file, tables and lists among them."""
    items = table.items() if isinstance(table, dict) else enumerate(table) if isinstance(table, list) else ()
    for key, value in items:
        yield (*at, key)
        if not isinstance(table, list) or key < 2:  # of many alike the first two will do
            yield from places(value, (*at, key))


def altered(table: dict[str, Any], at: Place, value: Any) -> dict[str, Any]:
    """Return a copy with another value in a place; ``value`` of `LEFT_OUT` takes it away."""
    changed = copy.deepcopy(table)
    inner: Any = changed
    for key in at[:-1]:
        inner = inner[key]
    if value is LEFT_OUT:
        del inner[at[-1]]
    else:
        inner[at[-1]] = value
    return changed


def mutants(table: dict[str, Any]) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield what was done, and the file with it done: each value in each place, each place left out."""
    for at in places(table):
        for value in (LEFT_OUT, *VALUES):
            shown = "left out" if value is LEFT_OUT else repr(value)[:40]
            yield f"{'.'.join(map(str, at))} = {shown}", altered(table, at, value)


def toml_of(tables: Any) -> str:
    """Return tables as TOML, a line a key of the file: also what the program would not write."""
    return "".join(f"{_key(name)} = {_value(value)}\n" for name, value in tables.items())


def _key(name: str) -> str:
    return json.dumps(name).replace("\x7f", "\\u007f")


def _value(value: Any) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_key(name)} = {_value(each)}" for name, each in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_value, value)) + "]"
    if isinstance(value, date | datetime):
        return value.isoformat()
    return repr(value)
