"""Which tests stand near a function: those that call it, import its file or lie in its mirrored folder."""

import ast
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import chain, takewhile
from pathlib import Path

MOST = 8  # files of tests that are traced for a mutant
CALLS_OF, IMPORTERS = "tests/recorded", 20  # of a module and those that import it
LOADER, LOADED = "fixtures_db/migrations/upgrade.py", "fixtures_db/migrations/versions/"  # by alembic
CALLS = "tests/test_recorded_calls.py::test_stored_calls_give_what_is_stored[{}]"


def imports(root: Path, packages: tuple[str, ...]) -> dict[str, set[str]]:
    """Return which of the packages' files each file of them imports, as paths from ``root``."""
    files = {str(path.relative_to(root)) for name in packages for path in (root / name).rglob("*.py")}
    graph = {file: _imported(root, file, files) for file in files}
    graph.get(LOADER, set()).update(file for file in files if file.startswith(LOADED))
    return graph


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


def near(file: str, graph: Mapping[str, set[str]], most: int = MOST) -> list[str]:
    """Return the test files near ``file``: its mirror and what imports it, then what imports these, and so on.

    After the first of these come all of its mirrored folder: they may reach it by a table. They are of the same
    room (`procedures`, `station.files` ...), where there are some: tests of whole programs take long to try.
    """
    first, *others = _layers(file, graph)
    beside = [test for test in sorted(graph) if Path(test).parent == Path("tests", file).parent]
    layers = [first, [test for test in beside if "/test_" in test and test not in first], *others]
    of_room = [[test for test in layer if _shared(test, file) >= _depth(file)] for layer in layers]
    return list(dict.fromkeys(chain(*(of_room if any(of_room) else layers))))[:most]


def recorded(file: str, graph: Mapping[str, set[str]], root: Path) -> list[str]:
    """Return the tests that make stored calls of ``file`` again, and those of the modules that import it."""
    importers = sorted(
        each for each, imported in graph.items() if file in imported and not each.startswith("tests")
    )
    modules = [file, *importers[:IMPORTERS]]
    return [CALLS.format(each) for each in modules if (root / CALLS_OF / each).with_suffix(".json").is_file()]


def _layers(file: str, graph: Mapping[str, set[str]]) -> Iterator[list[str]]:
    """Yield the tests that are 0, 1, 2 ... imports away, those first that share the most of its path."""
    found, seen, layer = set[str](), set[str](), {file}
    of_folder: dict[str, list[str]] = {}
    for test in graph:
        of_folder.setdefault(test.rpartition("/")[0], []).append(test)
    while layer:
        importers = {each for each, imported in graph.items() if imported & layer}
        tests = {test for each in layer for test in _mirrors(each, of_folder)}
        tests |= {each for each in importers if Path(each).name.startswith("test_")}
        mirrors = set(_mirrors(file, of_folder))
        yield sorted(tests - found, key=lambda test: (test not in mirrors, -_shared(test, file), test))
        found, seen = found | tests, seen | layer
        layer = importers - seen - tests


def _depth(file: str) -> int:
    return 2 if file.startswith("station/") else 1


def _mirrors(file: str, of_folder: Mapping[str, list[str]]) -> list[str]:
    """Return the tests of the folder mirrored, and the one above, that share a file's name, or the begin of it."""
    folder, stem = f"tests/{file}".rpartition("/")[0], Path(file).stem.strip("_")
    tests = [test for each in (folder, folder.rpartition("/")[0]) for test in of_folder.get(each, ())]
    names = {test: Path(test).stem for test in tests if "/test_" in test}
    return [t for t, name in names.items() if stem in name or stem.startswith(name.removeprefix("test_"))]


def _shared(test: str, file: str) -> int:
    pairs = zip(Path(test).parts[1:], Path(file).parts, strict=False)
    return sum(1 for _ in takewhile(lambda pair: pair[0] == pair[1], pairs))


def ordered(
    close: Sequence[str], callers: Mapping[str, Sequence[str]], seconds: Callable[[str], float], most_s: float
) -> list[str]:
    """Return the tests of a function, the likeliest to notice a change first, for ``most_s``.

    ``callers`` are those that call it, by their file: first of files ``close`` by, then of others. All else of
    these files follows: what a test does may be kept for the next, or done in a process of its own.
    """

    def rank(test: str) -> tuple[bool, bool, float, str]:
        return test not in callers, test not in close, seconds(test), test

    chosen, spent = list[str](), 0.0
    for each in sorted({*close, *callers}, key=rank):
        spent += seconds(each)
        if spent > most_s and chosen:
            break
        chosen.append(each)
    return [*dict.fromkeys(test for each in chosen for test in callers.get(each, ())), *chosen]
