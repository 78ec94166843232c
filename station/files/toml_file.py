"""TOML read into typed tables with the line of each key, and written; names and free text that may stand in files.

A name becomes part of names of files and pages: it is short, printable, and no path. Free text may have letters of
any script, but nothing that moves the cursor or turns the direction of writing (Unicode categories `_UNSEEN`).
"""

import json
import re
import tomllib
import unicodedata
from collections.abc import Iterator, Mapping, Sequence
from datetime import date, datetime
from pathlib import Path
from shlex import quote
from typing import Annotated, Any, TypeVar, get_args

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, StringConstraints, ValidationError
from pydantic_core import ErrorDetails

from fixtures_db.hash_chain import utc_text
from procedures.errors import ErrorCode
from station.errors import DataRefused
from station.files.opening import MAX_LINE, open_inside


def toml_text(tables: Mapping[str, object]) -> str:
    """Return nested tables as TOML; a key without a value is omitted."""
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


Key = tuple[str | int, ...]
T = TypeVar("T", bound=BaseModel)

_HEADER = re.compile(r"\s*(\[\[?)\s*([A-Za-z0-9_.\"\s]+?)\s*\]")
_PART = re.compile(r"\"[^\"]*\"|[^.\"]+")
_ENTRY = re.compile(r"\s*([A-Za-z0-9_]+(?:\.[A-Za-z0-9_]+)*)\s*=")
MAX_SHOWN = 60  # characters of a value in a message
_AT_LINE = re.compile(r"\(at line (\d+), column \d+\)")


class TomlTable(BaseModel):
    """A table of a file: types as they are written, no key that is not known, finite numbers."""

    model_config = ConfigDict(
        extra="forbid", strict=True, frozen=True, allow_inf_nan=False, serialize_by_alias=True
    )


class PlaceTable(TomlTable):
    """``[site]``: where something was recorded."""

    latitude_deg: Annotated[float, Field(ge=-90, le=90)]
    longitude_deg: Annotated[float, Field(ge=-180, le=360)] | None = None
    height_m: Annotated[float, Field(ge=-1000, le=20000)] = 0.0
    gravity_m_s2: Annotated[float, Field(ge=9.5, le=10.1)] | None = None


def read_folder_toml(folder: Path, name: str, kind: type[T]) -> tuple[T, dict[Key, int], bytes]:
    """Read the TOML file ``name`` of a folder.

    Returns
    -------
    tables, lines, content
        ``lines`` maps a key's path such as ``("dwell", 3, "file")`` to its line number.

    Raises
    ------
    DataRefused
        If there is no such folder, or a file in its place; with the line of the first key that is wrong, unknown
        or missing.
    """
    path = folder / name
    if not folder.is_dir():
        found, remedy = "no such folder", f"name a {path.stem} folder"
        if folder.is_file():
            found, remedy = "a file", f"{remedy}, or type station diagnose {quote(str(folder))} if it is a log"
        raise DataRefused(folder, None, found, f"a folder with a {name}", remedy, ErrorCode.FILE_MISSING)
    with open_inside(folder, name, folder, None) as stream:
        content = stream.read(MAX_LINE + 1)
    if len(content) > MAX_LINE:
        raise DataRefused(path, None, "more than 1 MiB", f"a {name} of at most 1 MiB")
    return *read_tables(content, path, kind), content


def read_tables(content: bytes, path: Path, kind: type[T]) -> tuple[T, dict[Key, int]]:
    """Return TOML text as the tables of ``kind``, and each key's line; refuse as `read_folder_toml` does."""
    raw = _parse(content, path)
    lines = line_of_keys(content.decode())
    try:
        return kind.model_validate(raw), lines
    except ValidationError as error:
        faults = error.errors(include_url=False)
        unknown = [fault for fault in faults if fault["type"] == "extra_forbidden"]  # it explains what is missing
        raise _refusal((unknown or faults)[0], path, lines, kind) from None


def read_text_file(path: Path, most: int = MAX_LINE) -> bytes:
    """Return the bytes of a file of at most ``most``; raise `DataRefused` if it is not there or cannot be read."""
    try:
        content = path.read_bytes()
    except OSError as error:
        raise DataRefused(path, None, f"no readable file ({error.strerror})", "a file of text") from error
    if len(content) > most:
        limit = f"{most >> 20} MiB" if most >= 1 << 20 else f"{most} bytes"
        raise DataRefused(path, None, f"more than {limit}", f"a file of at most {limit}")
    return content


def _parse(content: bytes, path: Path) -> dict[str, Any]:
    try:
        return tomllib.loads(content.decode())
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        raise DataRefused(path, line, f"byte 0x{content[error.start]:02x}", "UTF-8 text") from None
    except RecursionError:
        raise DataRefused(path, None, "arrays nested too deep", "tables as the format describes them") from None
    except ValueError as error:  # TOMLDecodeError is one; so is an integer of thousands of digits
        at = _AT_LINE.search(str(error))
        what = _AT_LINE.sub("", str(error)).strip()
        raise DataRefused(path, int(at[1]) if at else None, f"no TOML ({what})", "valid TOML") from None


def line_of_keys(text: str) -> dict[Key, int]:
    """Return the line number of each table header and key, by its path with the index of array tables."""
    lines: dict[Key, int] = {(): 1}
    counts: dict[str, int] = {}
    table: Key = ()
    for number, line in enumerate(text.split("\n"), start=1):
        if header := _HEADER.match(line):
            name = "".join(header[2].split())
            table = tuple(part.strip('"') for part in _PART.findall(name))
            if header[1] == "[[":
                counts[name] = counts.get(name, -1) + 1
                table = (*table, counts[name])
            lines.setdefault(table, number)
        elif entry := _ENTRY.match(line):
            key = (*table, *entry[1].split("."))
            for end in range(len(table) + 1, len(key) + 1):
                lines.setdefault(key[:end], number)
    return lines


def line_of(key: Sequence[str | int], lines: dict[Key, int]) -> int:
    """Return the line of a key, or of the nearest table around it."""
    path = tuple(key)
    while path not in lines:
        path = path[:-1]
    return lines[path]


def _refusal(error: ErrorDetails, path: Path, lines: dict[Key, int], kind: type[BaseModel]) -> DataRefused:
    key = error["loc"]
    name = ".".join(str(part) for part in key if isinstance(part, str)) or "the file"
    line = line_of(key, lines)
    match error["type"]:
        case "missing":
            return DataRefused(path, line, f"no {name}", f"{name} to be given")
        case "extra_forbidden":
            return DataRefused(
                path, line, f"unknown key {ascii(name)[:MAX_SHOWN]}", f"one of {', '.join(_accepted(key, kind))}"
            )
        case "value_error":
            return DataRefused(path, line, f"{name} {_short(error['input'])}", expected_of(error))
        case "too_long":
            found = f"{name} with {len(error['input'])} entries"
            return DataRefused(path, line, found, f"at most {error['ctx']['max_length']}")
    return DataRefused(path, line, f"{name} = {_short(error['input'])}", expected_of(error))


def expected_of(error: ErrorDetails) -> str:
    """Return what a table expects in place of a value that it refuses, in its validator's words or pydantic's."""
    if error["type"] == "value_error":
        return str(error["ctx"]["error"])
    return error["msg"].removeprefix("Input should be ")


def _accepted(key: Key, table: type[BaseModel]) -> list[str]:
    for part in key[:-1]:
        if isinstance(part, str) and part in table.model_fields:  # else it is a table's name in a table of such
            annotation = table.model_fields[part].annotation
            kinds = (kind for kind in (*get_args(annotation), annotation) if isinstance(kind, type))
            table = next((kind for kind in kinds if issubclass(kind, BaseModel)), table)
    return [field.alias or name for name, field in table.model_fields.items()]


def _short(value: object) -> str:
    """Return a value of a file for a message; of a table the plain values."""
    if isinstance(value, dict):
        plain = [f"{key} = {_short(part)}" for key, part in value.items() if not isinstance(part, dict | list)]
        return f"with {', '.join(plain)[:MAX_SHOWN]}" if plain else "as it stands"
    text = ascii(value)
    return text if len(text) <= MAX_SHOWN else text[: MAX_SHOWN - 3] + "..."


LONGEST_NAME, LONGEST_TEXT = 64, 1000  # characters: a line of a certificate's table, and a paragraph
_UNSEEN = {"Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp"}


def unseen(text: str) -> str:
    """Return the code points of characters that are not seen, such as U+202E; empty where there are none."""
    return ", ".join(sorted({f"U+{ord(c):04X}" for c in text if unicodedata.category(c) in _UNSEEN}))


def checked_text(text: str) -> str:
    """Return free text as it is; raise ValueError if it is too long or has characters that are not seen."""
    if len(text) > LONGEST_TEXT:
        raise ValueError(f"at most {LONGEST_TEXT} characters, not {len(text)}")
    if found := unseen(text):
        raise ValueError(f"printable characters, not {found[:60]}")
    return text


def checked_name(name: str) -> str:
    """Return a name as it is; raise ValueError if it is empty, too long, a path, or not printable."""
    checked_text(name)
    if not name.strip() or name != name.strip() or len(name) > LONGEST_NAME:
        raise ValueError(f"a name of 1 to {LONGEST_NAME} characters without spaces at its ends")
    if set(name) & {"/", "\\"} or name.startswith("."):
        raise ValueError("a name that is no path: without / and \\, not beginning with a dot")
    return name


def matching(pattern: str, words: str) -> AfterValidator:
    """Return what takes text that matches ``pattern`` as a whole; a refusal expects it in ``words``."""

    def checked(text: str) -> str:
        if not re.fullmatch(pattern, text, re.ASCII):
            raise ValueError(words)
        return text

    return AfterValidator(checked)


Sha256 = Annotated[str, matching("[0-9a-f]{64}", "64 digits 0 to 9 and a to f, a SHA-256")]
Name = Annotated[str, AfterValidator(checked_name)]
Text = Annotated[str, StringConstraints(strip_whitespace=True, min_length=1), AfterValidator(checked_text)]
