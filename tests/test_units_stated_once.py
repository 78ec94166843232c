"""A conversion of units stands in `procedures/units.py` and nowhere else."""

import ast

from tests.paths import ROOT

HOME = ROOT / "procedures/units.py"
PACKAGES = ("procedures", "drivers", "fixtures_db", "station")


def assigned(text: str) -> set[str]:
    """Return the names that a module's top level gives a value."""
    parts = [node.targets for node in ast.parse(text).body if isinstance(node, ast.Assign)]
    return {
        each.id
        for targets in parts
        for target in targets
        for each in ast.walk(target)
        if isinstance(each, ast.Name)
    }


def test_no_other_module_defines_a_conversion_again() -> None:
    home = assigned(HOME.read_text(encoding="utf-8"))
    files = [file for package in PACKAGES for file in (ROOT / package).rglob("*.py") if file != HOME]
    twice = {str(file): home & assigned(file.read_text(encoding="utf-8")) for file in files}
    assert "RAD_PER_DEG" in home
    assert not {file: names for file, names in twice.items() if names}
