"""Which tests stand near a module: those that import it, directly or through other modules, the nearest first."""

import ast
from collections import deque
from collections.abc import Mapping
from pathlib import Path


def imports(root: Path, packages: tuple[str, ...]) -> dict[str, set[str]]:
    """Return which of the packages' files each file of them imports, as paths from ``root``."""
    files = {str(path.relative_to(root)) for name in packages for path in (root / name).rglob("*.py")}
    return {file: _imported(root, file, files) for file in files}


def _imported(root: Path, file: str, files: set[str]) -> set[str]:
    found, folder = set[str](), Path(file).parent
    for node in ast.walk(ast.parse((root / file).read_text(encoding="utf-8"))):
        names = list[str]()
        if isinstance(node, ast.Import):
            names = [each.name for each in node.names]
        elif isinstance(node, ast.ImportFrom):
            above = ".".join(folder.parts[: len(folder.parts) - node.level + 1]) + "." if node.level else ""
            names = [f"{above}{node.module}"] + [f"{above}{node.module}.{each.name}" for each in node.names]
        for name in names:
            path = name.replace(".", "/")
            found |= {f"{path}.py", f"{path}/__init__.py"} & files
    found |= (
        {str(parent / "conftest.py") for parent in (folder, *folder.parents)} & files if "tests" in file else set()
    )
    return found - {file}


def nearest(file: str, graph: Mapping[str, set[str]], cost: Mapping[str, float], most: int) -> list[str]:
    """Return up to ``most`` test files that reach ``file``: importers and those of its folder first."""
    importers: dict[str, set[str]] = {}
    for importer, imported in graph.items():
        for each in imported:
            importers.setdefault(each, set()).add(importer)
    away, waiting = {file: 0}, deque([file])
    while waiting:
        at = waiting.popleft()
        for importer in importers.get(at, ()):
            if importer not in away:
                away[importer] = away[at] + 1
                waiting.append(importer)
    mirrored = f"tests/{Path(file).parent}/"  # also what reaches it by a command line, which imports by name

    def rank(test: str) -> tuple[bool, int, float, str]:
        far = away.get(test, len(graph))
        return far > 1 and not test.startswith(mirrored), far, cost.get(test, 20.0), test

    found = {each for each in graph if each in away or each.startswith(mirrored)}
    return sorted((each for each in found if Path(each).name.startswith("test_")), key=rank)[:most]
