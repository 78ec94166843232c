"""The grammar of a term: numbers with their unit, names, ``+ - * / **``, parentheses and calls; nothing else.

    sum     = product, {("+" | "-"), product}
    product = signed, {("*" | "/"), signed}
    signed  = "-", signed | power
    power   = atom, ["**", signed]
    atom    = number, ["[", unit, "]"] | name, ["(", sum, {",", sum}, ")"] | "(", sum, ")" | "'", channel, "'"

A channel in quotes is an auxiliary one whose name has more than letters, digits and ``_``: ``'aux_fan-speed'``. A
unit is written in the same grammar, also with ``^`` for ``**`` and a middle dot for ``*``. Which names there are
is not asked here. Text is walked into nodes of our own: nothing is ever evaluated by Python. Nodes are equal
wherever they stand in their texts.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import lru_cache
from math import isfinite

from procedures.errors import TermRefused

MAX_CHARACTERS = 500
MAX_DEPTH = 30  # of parentheses, signs and powers within each other
_TOKEN = re.compile(
    r"\s*(?:(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)|(?P<name>[A-Za-z_][A-Za-z0-9_]*)"
    r"|'(?P<channel>aux_[^'\"\x00-\x1f\x7f]+)'|(?P<unit>\[[^][]*\])|(?P<sign>\*\*|[-+*/(),^\u00b7]))",
    re.ASCII,
)
_PLAIN = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
EXPECTED = "a number, a name or a parenthesis"
OF_UNITS = {"^": "**", "\u00b7": "*"}  # what only a unit is written with, and what it means


@dataclass(frozen=True, slots=True)
class Number:
    """A number, in ``unit`` where one stands behind it; ``at`` is where it begins in the text."""

    value: float
    unit: str
    at: int = field(default=0, compare=False)


@dataclass(frozen=True, slots=True)
class Name:
    """An input, a constant, a parameter, or in a unit its name."""

    name: str
    at: int = field(default=0, compare=False)


@dataclass(frozen=True, slots=True)
class Operation:
    """``+ - * / **`` of two; a sign before one is ``0 - x``."""

    sign: str
    left: "Node"
    right: "Node"
    at: int = field(default=0, compare=False)


@dataclass(frozen=True, slots=True)
class Call:
    """A function or an operator of its arguments."""

    name: str
    arguments: tuple["Node", ...]
    at: int = field(default=0, compare=False)


Node = Number | Name | Operation | Call


@lru_cache(maxsize=4096)
def parse(text: str, *, is_unit: bool = False) -> Node:
    """Return a term, or a unit, as nodes.

    Raises
    ------
    TermRefused
        With the place of what is not in the grammar.
    """
    if len(text) > MAX_CHARACTERS:
        raise TermRefused(text, 0, f"{len(text)} characters", f"at most {MAX_CHARACTERS}")
    return _Parser(text, is_unit).whole()


def channel_as_written(name: str) -> str | None:
    """Return an auxiliary channel's name as a term has it, quoted where it must be; None if it cannot be."""
    if _PLAIN.fullmatch(name):
        return name
    found = _TOKEN.fullmatch(quoted := f"'{name}'")
    return quoted if found is not None and found["channel"] else None


def names(node: Node) -> Iterator[Name]:
    """Yield every name in a term that is no function's."""
    return (each for each in _nodes(node) if isinstance(each, Name))


def calls(node: Node) -> Iterator[Call]:
    """Yield every call in a term."""
    return (each for each in _nodes(node) if isinstance(each, Call))


def _nodes(node: Node) -> Iterator[Node]:
    yield node
    match node:
        case Operation():
            yield from _nodes(node.left)
            yield from _nodes(node.right)
        case Call():
            for each in node.arguments:
                yield from _nodes(each)


@dataclass(frozen=True, slots=True)
class _Token:
    kind: str
    text: str
    at: int


class _Parser:
    def __init__(self, text: str, is_unit: bool) -> None:
        self.text, self.tokens, self.next, self.depth = text, list(_tokens(text, is_unit)), 0, 0

    def whole(self) -> Node:
        node = self.sum()
        if self.peek.kind != "end":
            self.refuse("the end, or an operator + - * / **")
        return node

    @property
    def peek(self) -> _Token:
        return self.tokens[self.next]

    def take(self, *signs: str) -> _Token | None:
        token = self.peek
        if token.kind == "sign" and token.text in signs:
            self.next += 1
            return token
        return None

    def refuse(self, expected: str) -> None:
        token = self.peek
        raise TermRefused(self.text, token.at, token.text or "the end", expected)

    def sum(self) -> Node:
        node = self.product()
        while token := self.take("+", "-"):
            node = Operation(token.text, node, self.product(), token.at)
        return node

    def product(self) -> Node:
        node = self.signed()
        while token := self.take("*", "/", "\u00b7"):
            node = Operation(OF_UNITS.get(token.text, token.text), node, self.signed(), token.at)
        return node

    def signed(self) -> Node:
        self.depth += 1
        if self.depth > MAX_DEPTH:
            self.refuse(f"at most {MAX_DEPTH} parentheses, signs or powers within each other")
        token = self.take("-")
        node = (
            self.power() if token is None else Operation("-", Number(0.0, "", token.at), self.signed(), token.at)
        )
        self.depth -= 1
        return node

    def power(self) -> Node:
        node = self.atom()
        if token := self.take("**", "^"):
            return Operation("**", node, self.signed(), token.at)
        return node

    def atom(self) -> Node:
        token = self.peek
        if token.kind in {"number", "name", "channel"}:
            self.next += 1
            if token.kind == "channel":  # never a function
                return Name(token.text, token.at)
            return self.number(token) if token.kind == "number" else self.name(token)
        if self.take("(") is None:
            self.refuse(EXPECTED)
        node = self.sum()
        if self.take(")") is None:
            self.refuse(")")
        return node

    def number(self, token: _Token) -> Node:
        unit = ""
        if self.peek.kind == "unit":
            unit = self.peek.text[1:-1].strip()
            self.next += 1
        if not isfinite(value := float(token.text)):
            raise TermRefused(self.text, token.at, token.text, "a finite number")
        return Number(value, unit, token.at)

    def name(self, token: _Token) -> Node:
        if self.take("(") is None:
            return Name(token.text, token.at)
        arguments = [self.sum()]
        while self.take(","):
            arguments.append(self.sum())
        if self.take(")") is None:
            self.refuse(") or a comma")
        return Call(token.text, tuple(arguments), token.at)


def _tokens(text: str, is_unit: bool) -> Iterator[_Token]:
    at = 0
    while text[at:].strip():
        found = _TOKEN.match(text, at)
        if found is None or (found["sign"] in OF_UNITS and not is_unit):
            at += len(text[at:]) - len(text[at:].lstrip())
            raise TermRefused(text, at, text[at], f"{EXPECTED}, + - * / ** or a comma")
        kind = found.lastgroup or ""
        yield _Token(kind, found[kind], found.start(kind) - (kind == "channel"))  # its quote is its place
        at = found.end()
    yield _Token("end", "", len(text))
