"""Stored arguments made smaller: with fewer rows, shorter bytes and rounded numbers."""

import math
from collections import Counter
from collections.abc import Iterator
from itertools import pairwise
from typing import Any

from tests.recorded.stored_values import packed_bytes, unpacked

ROWS, BYTES = (8, 40, 200), (100, 600)
MANY, DIGITS = 6, 4  # numbers beyond which a column is rounded; to so many digits of how far they are apart


def smaller(tree: Any, size: int) -> Iterator[Any]:
    """Yield arguments with fewer rows, the fewest first, and then all of them."""
    lengths = Counter(_lengths(tree))
    if lengths:
        length = max(lengths, key=lambda each: each * lengths[each])
        for most in ROWS:
            if most * 1.3 < length and size * most / length < 1e5:
                yield rounded(_cut(tree, length, most))
    if longest := max(_sizes(tree), default=0):
        for most in BYTES:
            if most * 1.3 < longest:
                yield rounded(_shortened(tree, most))
    yield rounded(tree)


def _walk(tree: Any) -> Iterator[Any]:
    yield tree
    for each in tree.values() if isinstance(tree, dict) else tree if isinstance(tree, list) else ():
        yield from _walk(each)


def _lengths(tree: Any) -> Iterator[int]:
    for each in _walk(tree):
        if is_array(each) and isinstance(each["v"], list) and each["n"] and each["n"][0] > ROWS[0]:
            yield each["n"][0]


def is_array(tree: Any) -> bool:
    """Say whether a tree is an array; an object may have a field ``a`` of its own."""
    return isinstance(tree, dict) and {"a", "n", "v"} <= tree.keys()


def _sizes(tree: Any) -> Iterator[int]:
    for each in _walk(tree):
        if isinstance(each, dict) and isinstance(each.get("b"), str):
            yield len(unpacked(each["b"]))


def _cut(tree: Any, length: int, most: int) -> Any:
    if isinstance(tree, list):
        return [_cut(each, length, most) for each in tree]
    if not isinstance(tree, dict):
        return tree
    n = tree["n"] if is_array(tree) else []
    if n and isinstance(tree["v"], list) and abs(n[0] - length) <= 1:
        rows = most + n[0] - length
        each = len(tree["v"]) // n[0]
        return tree | {"n": [rows, *n[1:]], "v": tree["v"][: rows * each]}
    return {key: _cut(each, length, most) for key, each in tree.items()}


def _shortened(tree: Any, most: int) -> Any:
    if isinstance(tree, list):
        return [_shortened(each, most) for each in tree]
    if not isinstance(tree, dict):
        return tree
    if isinstance(tree.get("b"), str):
        return packed_bytes(unpacked(tree["b"])[:most])
    return {key: _shortened(each, most) for key, each in tree.items()}


def rounded(tree: Any) -> Any:
    """Return a tree whose arrays of many numbers have few digits."""
    if isinstance(tree, list):
        return [rounded(each) for each in tree]
    if not isinstance(tree, dict):
        return tree
    if (
        is_array(tree)
        and isinstance(tree["v"], list)
        and len(tree["v"]) > MANY
        and isinstance(tree["v"][0], float)
    ):
        columns = tree["n"][1] if len(tree["n"]) == 2 else 1
        v, places = tree["v"], [_places(tree["v"][i::columns]) for i in range(columns)]
        return tree | {"v": [round(x, places[i % columns]) if math.isfinite(x) else x for i, x in enumerate(v)]}
    return {key: rounded(each) for key, each in tree.items()}


def _places(column: list[float]) -> int:
    steps = sorted(abs(b - a) for a, b in pairwise(column) if a != b and math.isfinite(b - a))
    sizes = [abs(each) for each in column if each and math.isfinite(each)]
    scale = steps[len(steps) // 4] if steps else min(sizes, default=1.0)
    return min(DIGITS - math.floor(math.log10(scale or 1.0)), 17)
