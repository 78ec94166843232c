"""The mutants of a source file: one small change each, of what the program does and not of what it says.

Left alone are docstrings, annotations, decorators, `assert`, `raise`, f-strings, ``__all__`` and ``strict=``:
changes there cannot show in a result, or show in words alone.
"""

import ast
import copy
from collections.abc import Iterator
from dataclasses import dataclass

SWAPPED: dict[type[ast.AST], type[ast.AST]] = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.FloorDiv: ast.Mult,
    ast.Mod: ast.Mult, ast.Pow: ast.Mult, ast.LShift: ast.RShift, ast.RShift: ast.LShift, ast.BitAnd: ast.BitOr,
    ast.BitOr: ast.BitAnd, ast.Lt: ast.GtE, ast.GtE: ast.Lt, ast.Gt: ast.LtE, ast.LtE: ast.Gt, ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq, ast.Is: ast.IsNot, ast.IsNot: ast.Is, ast.In: ast.NotIn, ast.NotIn: ast.In,
    ast.And: ast.Or, ast.Or: ast.And,
}  # fmt: skip
BOUNDARY = {ast.Lt: ast.LtE, ast.LtE: ast.Lt, ast.Gt: ast.GtE, ast.GtE: ast.Gt}  # beside a whole number
NUMBERS = {"float", "int", "FloatArray", "IntArray"}
UNTOUCHED = (ast.Assert, ast.Raise, ast.JoinedStr, ast.Import, ast.ImportFrom)


@dataclass(frozen=True, slots=True)
class Mutant:
    """One change: where, by which operator, the text before and after, and the whole mutated source."""

    file: str
    line: int
    operator: str
    before: str
    after: str
    text: str
    source: str


def mutants(source: str, file: str = "") -> Iterator[Mutant]:
    """Yield every mutant of a source text."""
    lines = source.encode().splitlines(keepends=True)
    starts = [sum(map(len, lines[:i])) for i in range(len(lines))]
    for node, operator, after in changes(ast.parse(source)):
        assert isinstance(node, ast.expr | ast.stmt)
        assert node.end_lineno is not None
        assert node.end_col_offset is not None
        begin, end = starts[node.lineno - 1] + node.col_offset, starts[node.end_lineno - 1] + node.end_col_offset
        whole, text = source.encode(), lines[node.lineno - 1].decode().strip()
        new = ast.unparse(after) if isinstance(after, ast.stmt) else f"({ast.unparse(after)})"
        mutated = (whole[:begin] + new.encode() + whole[end:]).decode()
        yield Mutant(file, node.lineno, operator, ast.unparse(node), ast.unparse(after), text, mutated)


def changes(tree: ast.AST) -> Iterator[tuple[ast.AST, str, ast.AST]]:
    """Yield (node, operator, what stands in its place)."""
    returns: dict[ast.AST, str] = {}
    waiting: list[ast.AST] = [tree]
    while waiting:
        node = waiting.pop()
        if isinstance(node, UNTOUCHED) or (isinstance(node, ast.Assign) and "__all__" in ast.unparse(node)):
            continue
        if isinstance(node, ast.FunctionDef) and node.returns is not None:
            said = ast.unparse(node.returns)
            returns |= {each: said for each in ast.walk(node) if isinstance(each, ast.Return)}
        yield from _of_node(node, returns.get(node, ""))
        skipped = _skipped(node)
        waiting += [child for child in ast.iter_child_nodes(node) if child not in skipped]


def _skipped(node: ast.AST) -> set[ast.AST | None]:
    skipped: set[ast.AST | None] = {getattr(node, "annotation", None), getattr(node, "returns", None)}
    skipped |= set(getattr(node, "decorator_list", ()))
    if isinstance(node, ast.Call):
        skipped |= {each for each in node.keywords if each.arg == "strict"}
    return skipped


def _of_node(node: ast.AST, returns: str) -> Iterator[tuple[ast.AST, str, ast.AST]]:
    match node:
        case ast.BinOp(left=left, right=right, op=op) if type(op) in SWAPPED and not {left, right} & _words(node):
            yield node, "arithmetic", _with(node, op=SWAPPED[type(op)]())
        case ast.BoolOp(op=op):
            yield node, "and, or", _with(node, op=SWAPPED[type(op)]())
        case ast.Compare(ops=[op], comparators=[other]):
            yield node, "comparison", _with(node, ops=[SWAPPED[type(op)]()])
            if type(op) in BOUNDARY and isinstance(getattr(other, "value", None), int):
                yield node, "boundary", _with(node, ops=[BOUNDARY[type(op)]()])
        case ast.UnaryOp(op=ast.Not() | ast.USub() | ast.Invert(), operand=operand):
            yield node, "sign, not", operand
        case ast.Constant(value=bool() | int() | float() as value):
            yield node, "constant", ast.Constant(_another(value))
        case ast.Call(keywords=keywords):
            for i, each in enumerate(keywords):
                if each.arg not in {None, "strict", "dtype"}:
                    yield node, "argument dropped", _with(node, keywords=[*keywords[:i], *keywords[i + 1 :]])
        case ast.AugAssign():
            yield node, "statement dropped", ast.Pass()
        case ast.Assign(targets=[ast.Name(id=name)], value=value) if name in {
            each.id for each in ast.walk(value) if isinstance(each, ast.Name)
        }:
            yield node, "statement dropped", ast.Pass()
        case ast.Return(value=ast.expr() as value) if not isinstance(value, ast.Constant):
            if returns in NUMBERS:
                yield node, "return", ast.Return(ast.UnaryOp(ast.USub(), value))
            elif returns.endswith("| None"):
                yield node, "return", ast.Return(ast.Constant(None))


def _words(node: ast.BinOp) -> set[ast.expr]:
    sides = (node.left, node.right)
    return {
        each
        for each in sides
        if isinstance(each, ast.JoinedStr)
        or isinstance(getattr(each, "value", None), str | bytes)
        or hasattr(each, "values")
    }


def _another(value: float) -> float:
    if isinstance(value, bool):
        return not value
    return value + 1 if isinstance(value, int) else value * 1.1 or 1.0


def _with(node: ast.AST, **fields: object) -> ast.AST:
    new = copy.copy(node)
    for name, value in fields.items():
        setattr(new, name, value)
    return new
