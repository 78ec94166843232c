"""Calls that differ a little from those that tests made: one number, switch, row or byte is another one.

Tests give what is usual; a limit, a sign or a branch that their values never come near may be another one unseen.
Of the calls of a function one is taken, and changed at one to three places, each found by a chance choice at each
level of its arguments. What comes out is stored as it is, if the call can be made and raises nothing.
"""

import json
import math
import time
from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from random import Random
from typing import Any

from tests.recorded.candidates import Candidate, Guard, TooLong, limit, tried
from tests.recorded.held_values import HELD
from tests.recorded.noticed import in_a_fork
from tests.recorded.parts import parted, text_of
from tests.recorded.smaller import is_array
from tests.recorded.stored_values import packed_bytes, unpacked

MOST_TEXT, BASES = 150_000, 12  # of a variant, parts and all; calls of a function that are varied, the shortest
TRIED, OF_FUNCTION_S = 60, 0.5  # variants of a function; processor time for them
ONE_S = 0.4  # of one
STOP = 0.15  # chance that a list or an object is changed itself, not what is in it
FROM_ANOTHER = 0.3  # chance that the value of another call stands in a place

Path = tuple[str | int, ...]


def variants(module: str, calls: Sequence[tuple[str, Any]]) -> tuple[list[Candidate], dict[str, str]]:
    """Return calls of a module that differ a little from ``calls``, names with arguments, and their parts."""
    of = defaultdict[str, list[Any]](list)
    for name, tree in sorted(calls, key=lambda each: len(text_of(each[1]))):
        if name != HELD and tree["d"] and len(of[name]) < BASES:
            of[name].append(tree)
    found, texts = list[Candidate](), dict[str, str]()
    for name, trees in of.items():
        for each in in_a_fork(lambda: [*_tried(module, name, trees, Guard())]):  # noqa: B023
            own: dict[str, str] = {}
            tree = {"d": {key: parted(value, own) for key, value in json.loads(each.text)["d"].items()}}
            texts |= own
            found.append(Candidate(module, name, text_of(tree), tuple(own), each.cost, each.steps))
    return found, texts


def _tried(module: str, name: str, trees: Sequence[Any], guard: Guard) -> Iterator[Candidate]:
    chance, seen, end = Random(f"{module}:{name}"), set(map(text_of, trees)), time.process_time() + OF_FUNCTION_S
    for _ in range(TRIED):
        if time.process_time() > end:
            return
        limit(ONE_S)
        try:
            tree = varied(chance.choice(trees), trees, chance)
            if (text := text_of(tree)) in seen or len(text) > MOST_TEXT:
                continue
            seen.add(text)
            if found := tried(module, name, json.loads(text), guard, fails=False):
                yield found
        except (TooLong, Exception):
            continue
        finally:
            limit(0.0)


def varied(tree: Any, others: Sequence[Any], chance: Random) -> Any:
    """Return arguments with one to three places changed."""
    for _ in range(chance.choice((1, 1, 2, 3))):
        path = _place(tree, chance)
        if chance.random() < FROM_ANOTHER:
            with_it = [each for each in others if _at(each, path) is not None]
            value = _at(chance.choice(with_it), path) if with_it else None
            tree = tree if value is None or _refers(value) or _refers(tree) else _put(tree, path, value)
        else:
            node = _at(tree, path)
            tree = _put(tree, path, _changed(node, chance, whole=not _refers(tree)))
    return tree


def _place(tree: Any, chance: Random) -> Path:
    """Return the way to a place, an argument at least."""
    path, node = ("d", chance.choice([*tree["d"]])), None
    node = _at(tree, path)
    while (inner := [*_within(node)]) and chance.random() > STOP:
        path += (way := chance.choice(inner))
        node = _at(node, way)
    return path


def _within(node: Any) -> Iterable[Path]:
    """Return the ways to what can be changed in a node."""
    if isinstance(node, list):
        return [(i,) for i in range(len(node))]
    if not isinstance(node, dict):
        return ()
    for kind in ("d", "f"):
        if kind in node and isinstance(node[kind], dict):
            return [(kind, key) for key in node[kind]]
    if "t" in node:
        return [("t", i) for i in range(len(node["t"]))]
    if "k" in node:
        return [("k", i, 1) for i in range(len(node["k"]))]
    return [("v",)] if "n" in node and not is_array(node) else ()


def _changed(node: Any, chance: Random, *, whole: bool) -> Any:
    """Return a node changed, or as it was; ``whole`` says that items may go, since no place counts them."""
    if isinstance(node, bool):
        return not node
    if isinstance(node, int):
        return chance.choice((node + 1, node - 1, 0, -node, 2 * node))
    if isinstance(node, float):
        return _number(node, chance)
    if isinstance(node, list):
        return _items(node, chance) if whole else node
    if is_array(node) and isinstance(node["v"], list) and node["v"]:
        return node | {"v": _array(node["v"], chance)}
    if isinstance(node, dict) and isinstance(node.get("b"), str):
        return packed_bytes(_bytes(unpacked(node["b"]), chance))
    return node


def _number(number: float, chance: Random) -> float:
    if not math.isfinite(number):
        return 1.0
    times = chance.choice((0.0, -1.0, 0.5, 0.95, 1.05, 2.0, 10.0))
    return number * times if number else chance.choice((1.0, -1.0, 1e-3))


def _items(items: list[Any], chance: Random) -> list[Any]:
    i = chance.randrange(len(items)) if items else 0
    return chance.choice((items[:i] + items[i + 1 :], items[: i + 1] + items[i:], items[::-1]))


def _array(values: list[Any], chance: Random) -> list[Any]:
    if isinstance(values[0], dict):
        return values
    i = chance.randrange(len(values))
    if isinstance(values[0], float):
        of_all, one = chance.choice((-1.0, 0.5, 1.3, 1.0, 1.0)), chance.choice((1.0, math.nan, 3.0, -1.0))
        return [(of_all * each * one if k == i else of_all * each) for k, each in enumerate(values)]
    of_one = _changed(values[i], chance, whole=False)
    return [of_one if k == i else each for k, each in enumerate(values)]


def _bytes(content: bytes, chance: Random) -> bytes:
    i = chance.randrange(len(content)) if content else 0
    other = bytes([chance.randrange(256)])
    return chance.choice((content[:i], content[i:], content[:i] + other + content[i + 1 :], content + content[i:]))


def _refers(tree: Any) -> bool:
    """Say whether something in a tree is named by how many objects before it stands: none may come or go."""
    return '{"&":' in text_of(tree)


def _at(tree: Any, path: Path) -> Any:
    """Return what stands at a place, `None` where a tree has no such place."""
    for each in path:
        try:
            tree = tree[each] if isinstance(tree, list | dict) else None
        except (KeyError, IndexError, TypeError):
            return None
    return tree


def _put(tree: Any, path: Path, value: Any) -> Any:
    """Return a tree with another value in one place."""
    if not path:
        return value
    new: Any = tree.copy()
    new[path[0]] = _put(tree[path[0]], path[1:], value)
    return new
