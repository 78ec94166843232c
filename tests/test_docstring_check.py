"""The checker of docstrings: what it must see, and what it must let pass."""

from pathlib import Path

import pytest

from tests.docstring_check import lacking

GOOD = '''
def turned(C_nb: FloatArray, f_b: FloatArray) -> FloatArray:
    """Return specific force (n, 3) [m/s^2], East-North-Up: ``C_nb`` (3, 3) takes ``f_b`` (n, 3), body, there."""
'''
CASES = (
    ('"""Return it (n, 3) [m/s^2], level; ``C_nb`` (3, 3)."""', "`f_b` not named"),
    ('"""Return it (n, 3) [m/s^2]: ``C_nb`` (3, 3). Then comes ``f_b``."""', "no shape of `f_b`"),
    ('"""Return what ``C_nb`` (3, 3) makes of ``f_b`` (n, 3)."""', "no unit"),
    ("'Turn.'", "`C_nb` not named"),
)


def found(folder: Path, text: str) -> list[str]:
    (folder / "module.py").write_text(text)
    return list(lacking(folder / "module.py"))


def test_a_whole_docstring_passes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert found(Path(), GOOD) == []


@pytest.mark.parametrize(("docstring", "reported"), CASES)
def test_what_lacks_is_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, docstring: str, reported: str
) -> None:
    monkeypatch.chdir(tmp_path)
    head = "def turned(C_nb: FloatArray, f_b: FloatArray) -> FloatArray:\n    "
    (line,) = found(Path(), head + docstring + "\n")
    assert reported in line


def test_three_arrays_want_a_section(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    head = "def total(a: FloatArray, b: FloatArray, c: FloatArray) -> float:\n    "
    text = head + '"""Sum ``a`` (n,), ``b`` (n,), ``c`` (n,) [m]."""\n'
    (line,) = found(Path(), text)
    assert "no Parameters section" in line
