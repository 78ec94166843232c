"""Make a stored call again, and tell where what it gives differs from what is stored."""

import inspect
import json
import os
import tempfile
import warnings
from collections.abc import Collection, Iterator, Mapping
from contextlib import chdir
from functools import cached_property
from importlib import import_module
from itertools import islice
from pathlib import Path
from typing import Any

from tests.paths import ROOT
from tests.recorded.folders import HERE, contents
from tests.recorded.held_values import HELD, held
from tests.recorded.parts import parts, text_of, whole
from tests.recorded.result_columns import columns_of, digest
from tests.recorded.stored_values import Decoder, Encoder
from tests.stored.held import differences

STORED = ROOT / "tests/recorded"
MOST_ITEMS = 1000  # that are taken of an iterator
MOST_COLUMNS = 30  # of a result that are stored with their paths
Columns = dict[str, list[Any]]
Call = dict[str, Any]  # "call": name in the module, "with": arguments, "gives": columns of the result


def stored(module: str) -> Path:
    """Return where the calls of `procedures/counts/x.py` are stored."""
    return STORED / Path(module).with_suffix(".json")


def read(module: str) -> list[Call]:
    """Return the calls stored of a module."""
    found: list[Call] = json.loads(stored(module).read_text(encoding="utf-8"))
    return [each | {"with": whole(each["with"], parts())} for each in found]


def write(module: str, calls: list[Call]) -> None:
    """Write the calls of a module, or remove their file if there are none."""
    file = stored(module)
    if not calls:
        file.unlink(missing_ok=True)
        return
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text("[\n" + ",\n".join(map(text_of, calls)) + "\n]\n", encoding="utf-8")


def different(module: str) -> str:
    """Return what stored calls of a module give otherwise now, "" if they do not."""
    for number, call in enumerate(read(module)):
        try:
            changes = "changes" in call["gives"]
            found = outcome(module, call["call"], call["with"], changes=changes)
        except Exception as error:
            return f"{module}: call {number} of {call['call']} cannot be made now: {type(error).__name__}: {error}"
        if wrong := list(differing(found, call["gives"])):
            return f"{module}: call {number} of {call['call']}: {len(wrong)} differ: {' | '.join(wrong[:3])}"
    return ""


def short(columns: Columns, without: Collection[str] = ()) -> dict[str, Any]:
    """Return columns as they are stored: of many their numbers, and digests of their paths and of all else."""
    columns = {path: values for path, values in columns.items() if path not in without}
    of_all: dict[str, Any] = {"without": sorted(without)} if without else {}
    of_all |= {"changes": 1} if any(path.startswith("after") for path in columns) else {}
    if len(columns) <= MOST_COLUMNS:
        return columns | of_all
    numbers = {path: values for path, values in columns.items() if _has_float(values)}
    words = {path: values for path, values in columns.items() if path not in numbers}
    found = {"fields": len(columns), "paths": digest(list(columns)), "words": digest(words)}
    return found | {"numbers": [*numbers.values()]} | of_all


def differing(found: Columns, gives: Mapping[str, Any]) -> Iterator[str]:
    """Yield where columns are not those stored, a line each."""
    without = gives.get("without", ())
    if "numbers" not in gives:
        yield from differences(
            found, {path: values for path, values in gives.items() if path not in {"without", "changes"}}
        )
        return
    now = short(found, without)
    if [now.get(each) for each in ("fields", "paths")] != [gives["fields"], gives["paths"]]:
        yield f"found {now.get('fields', len(found))} fields, expected {gives['fields']}, or others"
    elif now["words"] != gives["words"] or len(now["numbers"]) != len(gives["numbers"]):
        yield f"a word or whole number of {len(found)} fields is another one"
    else:
        paths = [path for path, values in found.items() if path not in without and _has_float(values)]
        of_numbers = [dict(zip(paths, each["numbers"], strict=True)) for each in (now, gives)]
        yield from differences(*of_numbers)


def _has_float(values: list[Any]) -> bool:
    return any(isinstance(each, float) for each in values)


def function(module: str, name: str) -> Any:
    """Return a function or method as it stands in the source, but for kernels: without caches and properties."""
    found: Any = import_module(module.removesuffix(".py").replace("/", "."))
    for each in name.split("."):
        found = inspect.getattr_static(found, each)
    if isinstance(found, property):
        found = found.fget
    if isinstance(found, cached_property):
        found = found.func
    if isinstance(found, staticmethod | classmethod):
        found = found.__func__
    return found if hasattr(found, "py_func") else inspect.unwrap(found)


def handed(called: Any, values: dict[str, Any]) -> tuple[list[Any], dict[str, Any]]:
    """Return arguments stored by their names as they are handed over; those that are not stored have defaults."""
    asked = inspect.signature(called).parameters
    if unknown := values.keys() - asked.keys():
        raise LookupError(f"it has no argument {', '.join(sorted(unknown))}")
    if missing := [name for name, each in asked.items() if _is_needed(each) and name not in values]:
        raise LookupError(f"it needs {', '.join(missing)}, which is not stored")
    given, named = list[Any](), dict[str, Any]()
    for name, value in values.items():
        kind = asked[name].kind
        if kind is inspect.Parameter.VAR_KEYWORD:
            named |= value
        elif kind is inspect.Parameter.VAR_POSITIONAL:
            given += value
        elif list(asked).index(name) == len(given) and kind is not inspect.Parameter.KEYWORD_ONLY:
            given.append(value)
        else:
            named[name] = value
    return given, named


def _is_needed(parameter: inspect.Parameter) -> bool:
    is_one = parameter.kind not in {inspect.Parameter.VAR_KEYWORD, inspect.Parameter.VAR_POSITIONAL}
    return is_one and parameter.default is inspect.Parameter.empty


def outcome(module: str, name: str, arguments: Any, *, changes: bool = True) -> dict[str, list[Any]]:
    """Return as columns what a call gives and makes in its folder, and which ``changes`` to its arguments."""
    room = os.environ.get("PYTEST_DEBUG_TEMPROOT")  # in memory: a disk takes its time for each of 4,400 folders
    with tempfile.TemporaryDirectory(dir=room) as folder, chdir(folder), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        HERE[0] = Path(folder)
        values, there = Decoder().of(arguments), contents(HERE[0])
        told = {"returns": held(module)} if name == HELD else told_by(function(module, name), values)
        files = {key: _words(each) for key, each in contents(HERE[0]).items() if there.get(key) != each}
        told |= {"files": files} if files else {}
        columns = columns_of({"d": told} if name == HELD else Encoder(strict=False).of(told), folder)
        if changes and (after := Encoder(strict=False).of(values)) != arguments:
            before, now = columns_of(arguments, folder), columns_of(after, folder)
            columns |= {f"after{path}": each for path, each in now.items() if before.get(path) != each}
    return columns


def told_by(called: Any, values: dict[str, Any]) -> dict[str, Any]:
    """Return what a call returns, an iterator as a list, or raises."""
    given, named = handed(called, values)
    try:
        found = called(*given, **named)
        return {"returns": list(islice(found, MOST_ITEMS)) if isinstance(found, Iterator) else found}
    except Exception as error:
        return {"raises": f"{type(error).__qualname__}: {error}"}


def _words(content: bytes) -> str:
    return content.decode(errors="backslashreplace")
