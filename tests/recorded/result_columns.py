"""What a stored call gives, taken apart to columns of numbers and words."""

import hashlib
import re
from collections.abc import Iterator
from typing import Any

from tests.paths import ROOT
from tests.recorded.parts import text_of
from tests.recorded.smaller import is_array
from tests.stored.held import MOST, kept

LONG = 160  # characters of a text, beyond which its hash is stored
NUMBER = re.compile(r"(?<![\w.])[+-]?\d+\.\d+(?:e[+-]?\d+)?")


def digest(value: Any) -> str:
    return hashlib.sha256(text_of(value).encode()).hexdigest()[:12]


def columns_of(tree: Any, folder: str) -> dict[str, list[Any]]:
    """Return the leaves of a tree by their paths; those of a list of more than some are a column together."""
    columns: dict[str, list[Any]] = {}
    for path, leaf in _leaves(tree, ""):
        if isinstance(leaf, list):
            columns.setdefault(path, []).extend(leaf)
            continue
        if not isinstance(leaf, str):
            columns.setdefault(path, []).append(leaf)
            continue
        leaf = leaf.replace(folder, "TMP").replace(str(ROOT), "TREE")
        words = NUMBER.sub("#", leaf)
        columns.setdefault(path, []).append(words if len(words) < LONG else digest(words))
        for number in NUMBER.findall(leaf):
            columns.setdefault(f"{path}#", []).append(float(number))
    return {path: kept(values) for path, values in columns.items()}


def _leaves(tree: Any, path: str) -> Iterator[tuple[str, Any]]:
    """Yield path and leaf; long lists of numbers whole."""
    if is_array(tree) and len(tree["n"]) == 2 and 0 < (wide := tree["n"][1]) <= MOST:
        yield path, f"{tree['n'][0]} x {wide}"
        values = tree["v"] if isinstance(tree["v"], list) else [tree["v"]]
        if _are_numbers(values):
            yield from ((f"{path}.{i}", values[i::wide]) for i in range(min(wide, len(values))))
            return
        for i, each in enumerate(values):
            yield from _leaves(each, f"{path}.{i % wide}")
    elif isinstance(tree, dict):
        for key, each in tree.items():
            yield from _leaves(each, f"{path}.{key}" if key not in {"v", "f"} else path)
    elif isinstance(tree, list) and len(tree) > MOST and _are_numbers(tree):
        yield path, tree
    elif isinstance(tree, list):
        yield from ((path, "[]") for _ in range(not tree))
        for i, each in enumerate(tree):
            yield from _leaves(each, path if len(tree) > MOST else f"{path}.{i}")
    else:
        yield path, tree


def _are_numbers(values: list[Any]) -> bool:
    return {int, float}.issuperset(map(type, values))
