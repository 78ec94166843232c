"""Count array functions whose docstring leaves out a shape, a unit or a parameter.

`python -m tests.docstring_check [FOLDER ...]`. A public function or method that takes or returns arrays names
every array parameter, each in a sentence or an entry with its shape; it gives the shape of what it returns, and
units. With more than two array parameters it has a Parameters section. Docstrings of class and module count too,
for units and for the names that they explain. ``[tool.docstring_check] allowed`` in pyproject.toml says how many
may be wrong: never more than now.

It counts words, no truth: that a shape stands there does not say that it is the right one. Reviews do.
"""

import ast
import re
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

from tests.paths import ROOT

PACKAGES = ("procedures", "drivers", "station", "fixtures_db")
ARRAYS = re.compile(r"\b(FloatArray|IntArray|BoolArray|ByteArray|NDArray|ndarray|ImageArray)\b")
TERM = r"(?:\d+|[a-zA-Z_]\w*(?: ?[-+*] ?\w+)?|\.\.\.)"
SHAPE = re.compile(rf"\({TERM}(?:, ?{TERM})*,?\)")
ALIKE = re.compile(r"\b(shape of|shaped like|as many as|shape as|scalar|same shape|a value per|one per|square)\b")
UNIT = re.compile(
    r"\[[^\]]+\]|\b(rad|m/s2?|m/s\^2|deg|counts?|quanta|Hz|ppm|px|pixels?|seconds|metres|SI|unit|units|number|numbers"
    r"|sigmas?|index|indices|rotation|quaternion|probabilit\w+|whitened|boolean|true|True|bytes|ns|degC)\b"
)


def main() -> int:
    """Print what lacks in the folders that are named, or count over all and hold the count to the limit."""
    asked = [Path(name) for name in sys.argv[1:]]
    folders = asked or [ROOT / package for package in PACKAGES]
    lacks = [line for folder in folders for path in sorted(folder.rglob("*.py")) for line in lacking(path)]
    if asked:
        print(*lacks, f"{len(lacks)} docstrings lack something", sep="\n")  # noqa: T201
        return 0
    allowed = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["docstring_check"]["allowed"]
    if len(lacks) != allowed:
        print(*lacks, sep="\n")  # noqa: T201
        found = f"found {len(lacks)} array functions whose docstring lacks a shape or a unit, allowed {allowed}"
        print(f"{found}; mend them" if len(lacks) > allowed else f"{found}; lower `allowed` in pyproject.toml")  # noqa: T201
    return int(len(lacks) != allowed)


def lacking(path: Path) -> Iterator[str]:
    """Yield a line for every function of a file whose docstring lacks something."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    module = ast.get_docstring(tree) or ""
    for node in tree.body:
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
            around = f"{module}\n\n{ast.get_docstring(node) or ''}"
            for part in node.body:
                yield from _of_function(path, part, around, f"{node.name}.")
        else:
            yield from _of_function(path, node, module, "")


def _of_function(path: Path, node: ast.stmt, around: str, prefix: str) -> Iterator[str]:
    if not isinstance(node, ast.FunctionDef) or node.name.startswith("_"):
        return
    given = [
        a.arg for a in (*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs) if _is_array(a.annotation)
    ]
    returns = _is_array(node.returns)
    if given or returns:
        reported = ast.get_docstring(node) or ""
        wrong = list(_wrong(reported, around, given, returns))
        if wrong:
            where = path.relative_to(ROOT) if path.is_absolute() else path
            yield f"{where}:{node.lineno} {prefix}{node.name}: {', '.join(wrong)}"


def _is_array(annotation: ast.expr | None) -> bool:
    return annotation is not None and ARRAYS.search(ast.unparse(annotation)) is not None


def _wrong(reported: str, around: str, given: list[str], returns: bool) -> Iterator[str]:
    if len(given) > 2 and not re.search(r"^Parameters\n-+$", reported, re.M):
        yield "no Parameters section"
    texts = f"{reported}\n\n{around}"
    entries = re.split(r"(?<=[.;])\s+|\n\n|\n(?=\w[\w, ]* : )", texts)
    for name in given:
        of_name = [entry for entry in entries if re.search(rf"(?<![\w.]){re.escape(name)}(?!\w)", entry)]
        if not of_name:
            yield f"`{name}` not named"
        elif not any(_has_shape(entry) for entry in of_name):
            yield f"no shape of `{name}`"
    if returns and not _has_shape(reported):
        yield "no shape of what it returns"
    if not UNIT.search(texts):
        yield "no unit"


def _has_shape(text: str) -> bool:
    return any("," in found[0] for found in SHAPE.finditer(text)) or ALIKE.search(text) is not None


if __name__ == "__main__":
    sys.exit(main())
