"""``station fixtures tolerance``: a cube of the database or of a file, to text, JSON and SVG."""

import json
import re
from pathlib import Path
from xml.etree import ElementTree

import pytest

from procedures.tolerance.drawing_items import ITEMS
from station import cli

FEW = ("--cubes", "2000")


def run(capsys: pytest.CaptureFixture[str], tmp_path: Path, *arguments: str) -> tuple[int, str]:
    code = cli.run(["fixtures", "tolerance", *arguments, *FEW, "--db", str(tmp_path / "s.db")])
    captured = capsys.readouterr()
    return code, captured.out + captured.err


def items_file(path: Path, more: str = "", **changed: float) -> Path:
    sizes = dict.fromkeys(ITEMS, 0.04) | changed
    rows = "\n".join(f"{item} = {size}" for item, size in sizes.items())
    path.write_text(f"side_mm = 400.0\n[tolerance_mm]\n{rows}\n{more}")
    return path


def test_the_paper_s_cube_of_the_database_is_reported_in_a_table(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    code, text = run(capsys, tmp_path, "P1", "--want-ug", "100", "--estimator", "twelve")
    assert code == 0
    split = (re.split(" {2,}", line.strip()) for line in text.splitlines())
    cells = {name: values for name, *values in split}
    assert cells["12-position, paper's case"] == [
        "167",
        "67.11",
        "100.6",
    ]  # Yao, Hu, He 2018, table 6, without noise
    assert cells["two-direction, paper's case"] == ["0.5214", "0.6903", "1.091"]
    rows = [line.split() for line in text.splitlines() if line.startswith("  t")]
    assert [row[0] for row in rows if "relax" in row] == ["t7", "t10"]
    assert "free positions" in text


def test_a_file_gives_the_same_as_the_database_and_both_are_written_as_json_and_svg(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = items_file(tmp_path / "P1.toml")
    found = []
    for name, source in (("db", ("P1",)), ("file", ("--items", str(file)))):
        out, svg = tmp_path / f"{name}.json", tmp_path / f"{name}.svg"
        asked = ("--want-ug", "0.2", "--json", str(out), "--svg", str(svg))
        assert run(capsys, tmp_path, *source, *asked) == (0, "")
        found.append((json.loads(out.read_text()), svg.read_bytes()))
        assert ElementTree.fromstring(svg.read_text()).tag == "{http://www.w3.org/2000/svg}svg"
    assert found[0] == found[1]
    document = found[0][0]
    assert document["format"] == "tolerance/1"
    assert document["bias"]["twelve"]["p1_case"] == pytest.approx([1.6704e-4, 0.6711e-4, 1.0065e-4], abs=1e-8)
    assert {one["item"] for one in document["allowed"]} == set(ITEMS)
    scale = document["scale_factor"]
    for rms, most, worst in zip(
        *(scale[key] for key in ("rms", "within_95_percent", "worst_case_at_most")), strict=True
    ):
        assert 0 < rms < most < worst


def test_what_the_paper_sets_aside_stands_in_the_answer_with_the_sizes_of_the_file(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = items_file(tmp_path / "a.toml", "[set_aside]\nquadratic = 30.0\n[campaign]\nseat_side_mm = 100.0")
    out = tmp_path / "o.json"
    assert run(capsys, tmp_path, "--items", str(file), "--json", str(out))[0] == 0
    found = {one["item"]: one for one in json.loads(out.read_text())["set_aside"]}
    assert found["quadratic"]["std"]["accelerometer.bias"] == pytest.approx([30e-6 / 3**0.5] * 3)
    seat = found["seat-base-parallelism"]
    assert seat["std"]["gyroscope.misalignment"][1] == pytest.approx(0.02 / 100 / 6**0.5)  # one of its two tilts
    assert (seat["size"], seat["unit"]) == (0.02, "mm")


def test_k2_stays_in_every_bias_but_is_no_fault_of_the_cube(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "o.json"
    assert run(capsys, tmp_path, "P1", "--k2-ug", "30", "--json", str(out))[0] == 0
    bias = json.loads(out.read_text())["bias"]
    assert bias["two"]["rms"] == pytest.approx([30e-6] * 3, rel=0.01)
    assert bias["joint"]["rms"] == pytest.approx([30e-6] * 3, rel=0.02)


@pytest.mark.parametrize(
    ("more", "changed", "reported"),
    [("", {"t1": 0.0}, "items.toml"), ("[cost]\nt3 = 0.0", {}, "t3"), ("[price]\nt3 = 1.0", {}, "price"),
     ("[set_aside]\nslab-colour = 1.0", {}, "slab-colour"), ("[campaign]\nturn_s = 0.0", {}, "turn_s")],
)  # fmt: skip
def test_an_items_file_with_a_fault_is_refused_by_name(
    more: str, changed: dict[str, float], reported: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = items_file(tmp_path / "items.toml", more, **changed)
    code, text = run(capsys, tmp_path, "--items", str(file))
    assert (code, "items.toml" in text, reported in text) == (3, True, True), text
