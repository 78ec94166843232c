"""Write the names that the code defines to stdout, in words and after file and line, for codespell.

Of a module these are its own name and its folder's, and those of functions, classes, arguments and variables.
"""

import ast
import re
import sys
from collections.abc import Iterator

from tests.paths import ROOT
from tests.user_text import PACKAGES

FOLDERS = (*PACKAGES, "tests")


def names(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Yield line and name of all that a module defines."""
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            yield node.lineno, node.name
        elif isinstance(node, ast.arg):
            yield node.lineno, node.arg
        elif isinstance(node, ast.Name | ast.Attribute) and isinstance(node.ctx, ast.Store):
            yield node.lineno, node.id if isinstance(node, ast.Name) else node.attr


def in_words(name: str) -> str:
    """Return the words of a name, ``_is_goodUnit`` as "is good unit"."""
    return " ".join(re.findall(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])", name)).lower()


def main() -> None:
    """Write each name once a line."""
    for folder in FOLDERS:
        for path in sorted((ROOT / folder).rglob("*.py")):
            file = path.relative_to(ROOT).as_posix()
            own = (1, f"{path.parent.name}_{path.stem}")
            for line, name in sorted({own, *names(ast.parse(path.read_text(encoding="utf-8")))}):
                sys.stdout.write(f"{file}:{line}: {in_words(name)}\n")


if __name__ == "__main__":
    main()
