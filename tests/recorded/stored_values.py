"""Values as JSON and back: numbers, arrays, and objects by what they would be pickled as.

Text, whole numbers, floats, `None` and lists are themselves; all else is an object of one or two letters:

==========  ======================================  ==========  =====================================
``t``       tuple                                   ``a``       array: dtype, shape ``n``, numbers ``v``
``d, k``    dict of texts; dict, pairs              ``n``       numpy's number
``s, fs``   set, frozenset                          ``b``       bytes
``g``       class, function, member of an enum      ``p``       path: where, and the files there
``o``       object: its class, and fields ``f``     ``r``       object: what makes it, and its state
``dt``      dtype                                   ``...``     the ellipsis
``&``       the same as that n objects above          ``?``       a result that cannot be stored: its class
==========  ======================================  ==========  =====================================
"""

import base64
import copyreg
import sys
import zlib
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import MISSING, fields, is_dataclass
from enum import Enum
from importlib import import_module
from operator import attrgetter
from pathlib import Path
from types import MethodType
from typing import Any

import numpy as np

from tests.paths import ROOT
from tests.recorded.folders import HERE, contents, placed
from tests.recorded.named_objects import name_of

OURS = {
    "procedures",
    "drivers",
    "fixtures_db",
    "station",
    "numpy",
    *sys.stdlib_module_names,
}  # others' have other fields one day
HEX = 64  # bytes, beyond which they are packed


class Unstorable(TypeError):
    """A value that text cannot stand for: a lock, an open port, a function within a function."""


class Encoder:
    """Values to JSON; ``strict`` raises `Unstorable`, else it is stored that such a thing was there.

    ``by_name``: an object that a module holds is stored by its name, not as what it is.
    """

    def __init__(self, *, strict: bool = True, by_name: bool = True) -> None:
        self.strict, self.by_name, self.places, self.alive = strict, by_name, dict[int, int](), list[Any]()

    def of(self, value: Any) -> Any:
        kind = type(value)
        if value is None or kind in {bool, int, float, str}:
            return value
        if simple := SIMPLE.get(kind):
            return simple(value)
        if kind is tuple:
            return {"t": [self.of(each) for each in value]}
        if isinstance(value, Enum) and value.name is not None and "|" not in value.name:
            return {"g": f"{kind.__module__}:{kind.__qualname__}.{value.name}"}
        if isinstance(value, np.generic) and kind is not np.void:
            return {"n": value.dtype.str, "v": self.of(value.item())}
        if isinstance(value, Path):
            return _path(value)
        if isinstance(value, np.dtype):
            return {"dt": _lists(np.lib.format.dtype_to_descr(value))}
        if kind in {set, frozenset}:
            return {"s" if kind is set else "fs": [self.of(each) for each in sorted(value, key=repr)]}
        if self.by_name and (held := name_of(value)):
            return {"g": ":".join(held)}
        if callable(value) and hasattr(value, "__qualname__") and not isinstance(value, MethodType):
            return self._tried(_named, value)
        if id(value) in self.places:
            return {"&": len(self.alive) - self.places[id(value)]}
        self.places[id(value)] = len(self.alive)
        self.alive.append(value)
        return self._object(value, kind)

    def _object(self, value: Any, kind: type) -> Any:
        if kind is list:
            return [self.of(each) for each in value]
        if kind is dict and all(type(each) is str for each in value):
            return {"d": {key: self.of(each) for key, each in value.items()}}
        if kind is dict:
            return {"k": [[self.of(key), self.of(each)] for key, each in value.items()]}
        if kind is np.ndarray:
            return self._array(value)
        if not self.strict and isinstance(value, BaseException):  # pickled otherwise where tblib is loaded
            return {"e": f"{kind.__qualname__}: {value}"}
        if not self.strict and kind.__module__.split(".")[0] not in OURS:
            return {"?": f"{kind.__module__}:{kind.__qualname__}"}
        return self._tried(self._reduced, value)

    def _tried(self, told: Callable[[Any], Any], value: Any) -> Any:
        try:
            return told(value)
        except Exception as error:
            kind = f"{type(value).__module__}:{type(value).__qualname__}"
            if self.strict:
                raise Unstorable(f"{kind}: {error}") from error
            return {"?": kind}

    def _array(self, array: Any) -> dict[str, Any]:
        how = {"W": 0} if not array.flags.writeable else {}
        how |= {"F": 1} if array.flags.f_contiguous and not array.flags.c_contiguous else {}
        if array.dtype.kind in "fiub":
            short = array.dtype.itemsize < 8 and array.dtype.kind == "f"
            values = [float(str(each)) for each in array.ravel()] if short else array.ravel().tolist()
            return {"a": array.dtype.str, "n": list(array.shape), "v": values} | how
        if array.dtype.kind == "O":
            return {"a": "O", "n": list(array.shape), "v": [self.of(each) for each in array.ravel()]} | how
        descr = _lists(np.lib.format.dtype_to_descr(array.dtype))
        return {"a": descr, "n": list(array.shape), "v": _packed(array.tobytes())} | how

    def _reduced(self, value: Any) -> dict[str, Any]:
        kind = type(value)
        reduce = copyreg.dispatch_table.get(kind)
        parts = reduce(value) if reduce else value.__reduce_ex__(4)
        if isinstance(parts, str):
            return _named(value)
        make, arguments, state, items, pairs = (*parts[:5], *[None] * (5 - len(parts[:5])))
        if getattr(make, "__name__", "") == "__newobj__" and arguments == (kind,) and items is pairs is None:
            if (found := _fields(value, state)) is not None:
                if not self.strict:
                    found = _told(found, kind)
                return {"o": _named(kind)["g"], "f": {key: self.of(each) for key, each in found.items()}}
        made: dict[str, Any] = {"r": [self.of(make), [self.of(each) for each in arguments]]}
        made |= {"st": self.of(state)} if state is not None else {}
        made |= {"l": [self.of(each) for each in items]} if items is not None else {}
        return made | ({"i": [[self.of(k), self.of(v)] for k, v in pairs]} if pairs is not None else {})


def _fields(value: Any, state: Any) -> dict[str, Any] | None:
    if state is None:
        return {}
    if isinstance(state, list) and is_dataclass(value):
        return {each.name: item for each, item in zip(fields(value), state, strict=True)}
    if hasattr(value, "__setstate__"):
        return None
    if isinstance(state, tuple) and len(state) == 2:
        return (state[0] or {}) | (state[1] or {})
    return state if isinstance(state, dict) else None


def _named(value: Any) -> dict[str, str]:
    module, name = value.__module__, value.__qualname__
    if attrgetter(name)(import_module(module)) is not value:
        raise Unstorable(f"{module}.{name} is another one")
    return {"g": f"{module}:{name}"}


def _path(path: Path) -> dict[str, Any]:
    if path.is_absolute() and path.is_relative_to(HERE[0]):
        files = {name: _text(each) for name, each in contents(path).items()}
        return {"p": f"tmp:{path.relative_to(HERE[0])}", "files": files}
    return {
        "p": f"tree:{path.relative_to(ROOT)}" if path.is_absolute() and path.is_relative_to(ROOT) else str(path)
    }


def _text(content: bytes) -> Any:
    try:
        return content.decode()
    except UnicodeDecodeError:
        return packed_bytes(content)


def packed_bytes(value: bytes) -> dict[str, str]:
    return {"b": value.hex()} if len(value) <= HEX else {"b": _packed(value)}


def _packed(value: bytes) -> str:
    return "z" + base64.b85encode(zlib.compress(value, 9)).decode()


def unpacked(text: str) -> bytes:
    return zlib.decompress(base64.b85decode(text[1:])) if text.startswith("z") else bytes.fromhex(text)


def _lists(descr: Any) -> Any:
    return [_lists(each) for each in descr] if isinstance(descr, list | tuple) else descr


def _tuples(descr: Any) -> Any:
    if isinstance(descr, str):
        return descr
    of_fields = [(each[0], _tuples(each[1]), *([tuple(each[2])] if len(each) > 2 else [])) for each in descr]
    return of_fields


def _told(found: dict[str, Any], kind: type) -> dict[str, Any]:
    """Return fields without those that are plain defaults: a field that comes moves no result."""
    plain = {
        name: value for name, value in _defaults(kind) if value is None or isinstance(value, bool | str | tuple)
    }
    return {
        name: each
        for name, each in found.items()
        if name not in plain or type(each) is not type(plain[name]) or each != plain[name]
    }


def _defaults(kind: type) -> Iterator[tuple[str, Any]]:
    """Yield the fields of a dataclass that have a default: some may have come since."""
    for each in fields(kind) if is_dataclass(kind) else ():
        if each.default is not MISSING or each.default_factory is not MISSING:
            yield each.name, each.default if each.default is not MISSING else each.default_factory()


NO_PLACE = {"g": "builtins:complex"}, {"g": "builtins:slice"}  # of them none is in `made`: no `&` means one
SIMPLE: dict[type, Callable[[Any], Any]] = {
    bytes: packed_bytes,
    complex: lambda value: {"r": [NO_PLACE[0], [value.real, value.imag]]},
    type(...): lambda _: {"...": 1},
    slice: lambda value: {"r": [NO_PLACE[1], [value.start, value.stop, value.step]]},
}  # fmt: skip


class Decoder:
    """Values from JSON, in the order in which they were stored."""

    def __init__(self) -> None:
        self.made = list[Any]()

    def of(self, tree: Any) -> Any:
        if isinstance(tree, list):
            found: list[Any] = []
            self.made.append(found)
            found += [self.of(each) for each in tree]
            return found
        if not isinstance(tree, dict):
            return tree
        kind = next(iter(tree))
        made: Any = getattr(self, f"_{NAMES[kind]}")(tree)
        return made

    def _tuple(self, tree: Any) -> Any:
        return tuple(self.of(each) for each in tree["t"])

    def _texts(self, tree: Any) -> Any:
        found: dict[str, Any] = {}
        self.made.append(found)
        for key, each in tree["d"].items():
            found[key] = self.of(each)
        return found

    def _pairs(self, tree: Any) -> Any:
        found: dict[Any, Any] = {}
        self.made.append(found)
        for key, each in tree["k"]:
            known = self.of(key)  # before the value, as they were stored: what comes again is named by its place
            found[known] = self.of(each)
        return found

    def _set(self, tree: Any) -> Any:
        return {self.of(each) for each in tree["s"]}

    def _frozenset(self, tree: Any) -> Any:
        return frozenset(self.of(each) for each in tree["fs"])

    def _number(self, tree: Any) -> Any:
        return np.array(self.of(tree["v"]), dtype=tree["n"])[()]

    def _bytes(self, tree: Any) -> bytes:
        return unpacked(tree["b"])

    def _dtype(self, tree: Any) -> Any:
        return np.dtype(_tuples(tree["dt"]))

    def _dots(self, _: Any) -> Any:
        return ...

    def _named(self, tree: Any) -> Any:
        module, name = tree["g"].split(":")
        return attrgetter(name)(import_module(module))

    def _again(self, tree: Any) -> Any:
        return self.made[len(self.made) - tree["&"]]

    def _path(self, tree: Any) -> Path:
        where, _, name = tree["p"].partition(":")
        if where == "tmp":
            files = {
                key: each.encode() if isinstance(each, str) else self._bytes(each)
                for key, each in tree["files"].items()
            }
            return placed("" if name == "." else name, files)
        return ROOT / name if where == "tree" else Path(tree["p"])

    def _array(self, tree: Any) -> Any:
        place = len(self.made)
        self.made.append(None)
        if tree["a"] == "O":
            array = np.empty(len(tree["v"]), object)
            array[:] = [self.of(each) for each in tree["v"]]
        elif isinstance(tree["v"], str):
            array = np.frombuffer(bytearray(unpacked(tree["v"])), np.dtype(_tuples(tree["a"])))
        else:
            array = np.array(tree["v"], dtype=tree["a"])
        array = array.reshape(tree["n"], order="C")
        array = np.asfortranarray(array) if "F" in tree else array
        if "W" in tree:
            array.flags.writeable = False
        self.made[place] = array
        return array

    def _fields(self, tree: Any) -> Any:
        kind = self._named({"g": tree["o"]})
        made = kind.__new__(kind)
        self.made.append(made)
        for name, value in _defaults(kind):
            object.__setattr__(made, name, value)
        for name, each in tree["f"].items():
            value = self.of(each)
            with suppress(AttributeError):  # a field that there is no longer
                object.__setattr__(made, name, value)
        return made

    def _reduced(self, tree: Any) -> Any:
        if tree["r"][0] in NO_PLACE:
            return self._named(tree["r"][0])(*tree["r"][1])
        place = len(self.made)
        self.made.append(None)
        made = self.made[place] = self.of(tree["r"][0])(*[self.of(each) for each in tree["r"][1]])
        if "st" in tree:
            self._with_state(made, self.of(tree["st"]))
        made.extend(self.of(each) for each in tree["l"]) if "l" in tree else None
        for key, each in tree.get("i", ()):
            known = self.of(key)
            made[known] = self.of(each)
        return made

    @staticmethod
    def _with_state(made: Any, state: Any) -> None:
        if hasattr(made, "__setstate__"):
            made.__setstate__(state)
            return
        parts: Iterable[Any] = state if isinstance(state, tuple) else (state,)
        for each in parts:
            for name, value in (each or {}).items():
                object.__setattr__(made, name, value)


NAMES = {
    "t": "tuple", "d": "texts", "k": "pairs", "s": "set", "fs": "frozenset", "n": "number", "b": "bytes",
    "g": "named",
    "&": "again", "p": "path", "a": "array", "o": "fields", "r": "reduced", "...": "dots", "dt": "dtype",
}  # fmt: skip
