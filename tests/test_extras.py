"""What a message recommends to install exists: a make target for an extra that pyproject.toml declares."""

import re
import tomllib

from procedures.optional_libraries import install_command
from tests.paths import ROOT

PACKAGES = ("station", "drivers", "procedures", "fixtures_db", "docs")
EXTRAS = set(tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["optional-dependencies"])


def test_no_message_names_the_project_as_a_package_of_an_index() -> None:
    files = [file for name in PACKAGES for kind in ("*.py", "*.md") for file in (ROOT / name).rglob(kind)]
    assert [str(file) for file in files if "pip install" in file.read_text(encoding="utf-8")] == []


def test_each_extra_that_is_recommended_is_declared() -> None:
    recommended = set[str]()
    for name in PACKAGES:
        for file in [*(ROOT / name).rglob("*.py"), *(ROOT / name).rglob("*.md")]:
            text = file.read_text(encoding="utf-8")
            recommended |= set(re.findall(r"make extra-([a-z]+)", text))
            recommended |= set(re.findall(r"ExtraMissing\(\"?\w+\"?, \"(\w+)\"", text))
            recommended |= set(re.findall(r"install_command\([\"'](\w+)[\"']\)", text))
    assert len(recommended) > 5
    assert recommended <= EXTRAS
    assert re.search(r"^extra-%: install$", (ROOT / "Makefile").read_text(), re.MULTILINE)
    assert install_command("web") == "make extra-web"
