"""The mutation run on a tree of two functions: one is tested, one is not."""

import subprocess
from pathlib import Path

import pytest

from tests.mutation.__main__ import drawn, reason, tried
from tests.mutation.neighbourhood import near, ordered
from tests.mutation.operators import Mutant, mutants
from tests.mutation.reach import Reach, function_at
from tests.mutation.trial import Tree

TESTED = '''"""Half of 2 * width is meant."""

def half(width: float) -> float:
    return width / 2
'''
UNTESTED = "from gauge.tested import half\n\ndef less(width: float) -> float:\n    return half(width) - 3\n"
TEST = "from gauge.tested import half\n\ndef test_half() -> None:\n    assert half(5.0) == 2.5\n"
LOOSE = "from gauge.untested import less\n\ndef test_less_is_a_number() -> None:\n    assert less(2.0) < 10\n"


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    root = tmp_path / "root"
    for name, text in {
        "gauge/tested.py": TESTED, "gauge/untested.py": UNTESTED, "tests/gauge/test_tested.py": TEST,
        "tests/gauge/test_untested.py": LOOSE, "pyproject.toml": "[tool.pytest.ini_options]\n",
    }.items():  # fmt: skip
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text)
    subprocess.run(["git", "init", "-q"], cwd=root, check=True)
    return root


def one(source: str, operator: str) -> Mutant:
    (found,) = (each for each in mutants(source) if each.operator == operator)
    return found


def test_what_no_test_holds_survives_and_the_tree_stays_as_it_was(tree: Path, tmp_path: Path) -> None:
    chosen = drawn(tree, ("gauge",), 1, 10)
    assert [each.file for each in sorted(chosen, key=lambda each: each.file)] == [
        "gauge/tested.py",
        "gauge/untested.py",
    ]
    constant = [each for each in mutants(UNTESTED, "gauge/untested.py") if each.operator == "constant"]
    tested = next(each for each in chosen if each.file == "gauge/tested.py")
    found = dict(tried(tree, tmp_path, ("gauge",), [tested, *constant], 1, 5))
    assert found == {tested: "tests/gauge/test_tested.py::test_half", constant[0]: ""}
    assert (tree / "gauge/tested.py").read_text() == TESTED == (tmp_path / "tree0/gauge/tested.py").read_text()


def test_a_planted_crash_is_seen_and_an_endless_loop_is_stopped(
    tree: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    copy = Tree(tree, tmp_path / "copy", ("gauge",), Reach(tmp_path / "reach"))
    copy.lay()
    crash = Mutant("gauge/tested.py", 1, "", "", "", "", "raise SystemError\n")
    hang = Mutant("gauge/tested.py", 1, "", "", "", "", "def half(width):\n    while True:\n        pass\n")
    assert copy.outcome(crash, "", ["tests/gauge/test_tested.py"], []) == "tests/gauge/test_tested.py"
    death = "def half(width):\n    __import__('os')._exit(1)\n"
    dead = Mutant("gauge/tested.py", 1, "", "", "", "", death)
    assert copy.outcome(dead, "half", ["tests/gauge/test_tested.py"], []) == "crash"
    monkeypatch.setattr("tests.mutation.trial.START_S", 1.0)
    monkeypatch.setattr("tests.mutation.trial.TIMES", 0.0)
    assert copy.outcome(hang, "half", ["tests/gauge/test_tested.py"], []) == "timeout"
    copy.end()


def test_functions_are_replaced_though_the_tests_conftest_freezes_them(tree: Path, tmp_path: Path) -> None:
    frozen = "import gc\n\ndef pytest_collection_finish() -> None:\n    gc.freeze()\n"
    (tree / "tests/conftest.py").write_text(frozen)
    copy = Tree(tree, tmp_path / "copy", ("gauge",), Reach(tmp_path / "reach"))
    copy.lay()
    assert copy.collected is not None
    how = {"file": "gauge/tested.py", "function": "half"}
    assert copy.collected.run(["tests/gauge/test_tested.py"], 60.0, **how)["failed"] == ""
    copy.end()


def test_a_test_that_fails_without_the_mutant_kills_none(tree: Path, tmp_path: Path) -> None:
    with (tree / "tests/gauge/test_untested.py").open("a") as file:
        file.write("\ndef test_broken() -> None:\n    assert less(9.0) == 0\n")
    (mutant,) = (each for each in mutants(UNTESTED, "gauge/untested.py") if each.operator == "constant")
    (found,) = tried(tree, tmp_path, ("gauge",), [mutant], 1, 5)
    assert found[1] == ""


@pytest.mark.parametrize(
    ("source", "operator", "after"),
    [
        ("x = (1 +\n  y) * 2", "arithmetic", "x = ((1 + y) / 2)"),
        ("x = -y", "sign, not", "x = (y)"),
        ("if not y: pass", "sign, not", "if (y): pass"),
        ("x = a < b", "comparison", "x = (a >= b)"),
        ("x = a and b", "and, or", "x = (a or b)"),
        ("x = f(x)", "statement dropped", "pass"),
        ("x += b", "statement dropped", "pass"),
        ("x = f(a, b=c)", "argument dropped", "x = (f(a))"),
        ("x = True", "constant", "x = (False)"),
        ("def f() -> float:\n    return a", "return", "def f() -> float:\n    return -a"),
        ("def f() -> X | None:\n    return a", "return", "def f() -> X | None:\n    return None"),
    ],
)
def test_every_operator_changes_what_it_says(source: str, operator: str, after: str) -> None:
    assert after in {each.source for each in mutants(source) if each.operator == operator}


def test_words_hints_and_what_checks_alone_are_left_alone() -> None:
    source = '''"""Of 2."""
from x import y
__all__ = ("a",) * 2
@dataclass(slots=True)
class A:
    b: Literal[2]
def f(x: Literal[3]) -> Literal[4]:
    """Return 5."""
    assert x > 0
    for a, b in zip(x, x, strict=True):
        raise ValueError("found 3" + str(2 * 3))
'''
    assert list(mutants(source)) == []


def test_a_mutant_is_equivalent_by_its_file_line_and_change() -> None:
    mutant = one("x = a < b", "comparison")
    known = {"file": "", "line": "x = a < b", "before": "a < b", "after": "a >= b", "reason": "never nan"}
    assert reason(mutant, [known]) == "never nan"
    assert reason(mutant, [known | {"line": "x = a < c"}]) == ""


def test_callers_close_by_come_first_and_their_whole_files_last() -> None:
    graph = {
        "a/b/c.py": set[str](),
        "tests/a/b/test_c.py": set[str](),
        "tests/a/test_importer.py": {"a/b/c.py"},
        "a/b/deep.py": set(),
        "a/user.py": {"a/b/deep.py"},
        "tests/a/test_user.py": set(),
    }
    close = near("a/b/c.py", graph)
    assert close == ["tests/a/b/test_c.py", "tests/a/test_importer.py"]
    assert near("a/b/c.py", graph, 1) == close[:1]
    assert near("a/b/deep.py", graph) == ["tests/a/b/test_c.py", "tests/a/test_user.py"]  # folder, importers
    callers = {
        "tests/a/test_importer.py": ["tests/a/test_importer.py::test_x"],
        "tests/far.py": ["tests/far.py::test_y"],
    }
    files = ["tests/a/test_importer.py", "tests/far.py", "tests/a/b/test_c.py"]
    first = ["tests/a/test_importer.py::test_x", "tests/far.py::test_y"]
    assert ordered(close, callers, lambda _: 2.0, 9.0) == [*first, *files]
    assert ordered(close, callers, lambda _: 2.0, 2.0) == [first[0], files[0]]


def test_a_line_belongs_to_the_outermost_function_whose_body_has_it() -> None:
    source = "class A:\n    def f(self, x=1):\n        def g():\n            return 2\n        return g\nb = 3\n"
    assert [function_at(source, line) for line in range(1, 7)] == ["", "", "A.f", "A.f", "A.f", ""]


def test_what_acts_as_its_module_is_imported_is_tried_in_a_process_of_its_own(tree: Path, tmp_path: Path) -> None:
    source = "WIDE = 2\n\ndef one() -> int:\n    return 1\n\nONE = one()\n\ndef half(width: float) -> float:\n"
    (tree / "gauge/tested.py").write_text(f"{source}    return width / WIDE / ONE\n")
    every = mutants((tree / "gauge/tested.py").read_text(), "gauge/tested.py")
    chosen = [each for each in every if each.operator == "constant"]
    found = dict(tried(tree, tmp_path, ("gauge",), chosen, 1, 5))
    assert found == dict.fromkeys(chosen, "tests/gauge/test_tested.py::test_half")
    assert len(chosen) == 2
