"""Write what users read to stdout, for codespell: texts of the program in its source, help and templates.

Of the source these are string literals of three words or more; comments, names and docstrings are developers'.
"""

import ast
import re
import sys
from collections.abc import Iterator

from tests.paths import ROOT

PACKAGES = ("station", "procedures", "drivers", "fixtures_db")
TEMPLATES = (".html", ".toml")
WORDS = 3  # from which on a literal is a text
CODE = re.compile(r"SELECT|INSERT|TRIGGER|\.[a-z-]+ \{|^ *\[\w+\]|=\"|</")  # SQL, styles, files


def texts(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Yield line and text of the literals of a module, but of docstrings; ``{}`` for what is put into them."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            continue
        if isinstance(node, ast.JoinedStr):
            yield (
                node.lineno,
                "".join(str(part.value) if isinstance(part, ast.Constant) else "{}" for part in node.values),
            )
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.lineno, node.value
        yield from texts(node)


def main() -> None:
    """Write each text after its file and line."""
    for package in PACKAGES:
        for path in sorted((ROOT / package).rglob("*")):
            name = path.relative_to(ROOT)
            if path.suffix == ".py":
                for line, text in texts(ast.parse(path.read_text(encoding="utf-8"))):
                    if len(re.findall(r"[A-Za-z]{2,}", text)) >= WORDS and not CODE.search(text):
                        sys.stdout.write(f"{name}:{line}: {' '.join(text.split())}\n")
            elif path.suffix in TEMPLATES:
                for line, text in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
                    shown = re.sub(r"<[^>]*>|\{[{%].*?[%}]\}", " ", text)
                    sys.stdout.write(f"{name}:{line}: {shown}\n")
    for path in sorted((ROOT / "tests/station/commands/__snapshots__/test_wording").glob("*.txt")):
        for line, text in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            sys.stdout.write(f"{path.relative_to(ROOT)}:{line}: {text}\n")


if __name__ == "__main__":
    main()
