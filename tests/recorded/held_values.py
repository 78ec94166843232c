"""What a module holds beside its code: values, and the defaults of fields and arguments."""

import ast
import inspect
import re
from collections.abc import Iterator
from dataclasses import MISSING, fields, is_dataclass
from importlib import import_module
from types import ModuleType
from typing import Any

from tests.paths import ROOT
from tests.recorded.stored_values import Encoder

HELD = ""  # the name of the call that stands for what a module holds
KINDS = ("set", "list", "dict", "defaultdict", "OrderedDict", "Counter", "deque")
ADDRESS = re.compile(r" at 0x[0-9a-f]+")


def held(module: str) -> dict[str, Any]:
    """Return as a stored value what a module holds, by ``NAME``, ``Class.field`` and ``function(argument)``."""
    imported = import_module(module.removesuffix(".py").replace("/", "."))
    tree, encoder = ast.parse((ROOT / module).read_text(encoding="utf-8")), Encoder(strict=False, by_name=False)
    return {"d": {name: encoder.of(value) for name, value in _held(tree.body, imported, "")}}


def _held(body: list[ast.stmt], within: ModuleType | type, prefix: str) -> Iterator[tuple[str, Any]]:
    for node in body:
        match node:
            case ast.ClassDef(name=name, body=inner) if name in vars(within):
                yield from _held(inner, vars(within)[name], f"{prefix}{name}.")
            case ast.FunctionDef(name=name) | ast.AsyncFunctionDef(name=name) if name in vars(within):
                yield from _defaults(vars(within)[name], f"{prefix}{name}")
            case ast.Assign(value=value) if _is_empty(value):
                continue  # it fills as it is used: what is in it is another test's
            case ast.Assign(targets=targets):
                names = [each.id for target in targets for each in ast.walk(target) if isinstance(each, ast.Name)]
                yield from ((f"{prefix}{name}", _value(within, name)) for name in names)
            case ast.AnnAssign(target=ast.Name(id=name), value=value):
                if value is not None or name in getattr(within, "model_fields", ()):
                    yield f"{prefix}{name}", _value(within, name)


def _is_empty(value: ast.expr) -> bool:
    """Say whether a value is a new set, list or dict with nothing in it, ``set[str]()``."""
    return isinstance(value, ast.Call) and not value.args and ast.unparse(value.func).startswith(KINDS)


def _value(within: ModuleType | type, name: str) -> Any:
    """Return a value of a module or class; of a field its default, or all that a schema says of it."""
    if isinstance(within, type) and name in (schema := getattr(within, "model_fields", {})):
        return ADDRESS.sub("", repr(schema[name]))
    if (
        isinstance(within, type)
        and is_dataclass(within)
        and name in (asked := {f.name: f for f in fields(within)})
    ):
        default, make = asked[name].default, asked[name].default_factory
        return default if default is not MISSING else None if make is MISSING else make()
    value = vars(within).get(name)
    is_annotation = type(value).__module__ == "typing"  # what may stand in a field
    return ADDRESS.sub("", repr(value)) if is_annotation else value


def _defaults(called: Any, name: str) -> Iterator[tuple[str, Any]]:
    try:
        asked = inspect.signature(getattr(called, "__func__", called)).parameters
    except (TypeError, ValueError):  # a property, or what is made of a function otherwise
        return
    for one, each in asked.items():
        if each.default is not each.empty:
            yield f"{name}({one})", each.default
