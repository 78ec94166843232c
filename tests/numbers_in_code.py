"""The numbers that somebody chose, as the code has them: constants, fields' and arguments' defaults.

Left out are nought and one, where sums and counters begin, and tables, which have tests of their own.
"""

import ast
from collections.abc import Iterator

from tests.paths import ROOT

MOST_CHARACTERS = 70  # of a value: what is longer is a table
FOLDERS = (
    "procedures", "drivers", "fixtures_db", "station/stream", "station/files", "station/results",
    "station/calibrated", "station/applying", "station/exports", "station/attitude", "station/text",
    "station/guide", "station/locate", "station/live_attitude", "station/monitor", "station/sending",
)  # fmt: skip


def numbers_in_code() -> dict[tuple[str, str], str]:
    """Return the values, as written, by file and name: ``NAME``, ``Class.field``, ``function(argument)``."""
    files = sorted(path for folder in FOLDERS for path in (ROOT / folder).rglob("*.py"))
    return {
        (str(file.relative_to(ROOT)), name): ast.unparse(value)
        for file in files
        for name, value in _named(ast.parse(file.read_text(encoding="utf-8")).body, "")
        if len(ast.unparse(value)) <= MOST_CHARACTERS and _is_chosen(value)
    }


def _is_chosen(value: ast.expr) -> bool:
    if isinstance(value, ast.Call) and isinstance(value.func, ast.Call):  # a function, remembered or wrapped
        return False
    numbers = [each.value for each in ast.walk(value) if isinstance(each, ast.Constant)]
    return any(type(each) in {int, float} and abs(each) not in {0, 1} for each in numbers)


def _named(body: list[ast.stmt], within: str) -> Iterator[tuple[str, ast.expr]]:
    for node in body:
        match node:
            case ast.ClassDef(name=name, body=inner):
                yield from _named(inner, f"{within}{name}.")
            case ast.FunctionDef(name=name, args=arguments):
                yield from ((f"{within}{name}({one})", value) for one, value in _defaults(arguments))
            case (
                ast.Assign(targets=[target], value=value) | ast.AnnAssign(target=target, value=ast.expr() as value)
            ):
                yield within + ast.unparse(target).strip("()"), value


def _defaults(arguments: ast.arguments) -> Iterator[tuple[str, ast.expr]]:
    placed = [*arguments.posonlyargs, *arguments.args]
    of_placed = zip(placed[len(placed) - len(arguments.defaults) :], arguments.defaults, strict=True)
    for each, value in [*of_placed, *zip(arguments.kwonlyargs, arguments.kw_defaults, strict=True)]:
        if value is not None:
            yield each.arg, value
