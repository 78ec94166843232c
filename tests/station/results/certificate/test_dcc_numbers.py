"""Every number of a digital certificate is the solution's, bit by bit; readers of others' making read the same."""

import json
import os
import subprocess
import sys
from base64 import b64decode
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from lxml import etree

from fixtures_db.hash_chain import canonical, digest
from station.results.certificate.dcc.digital_certificate import certificate_xml
from station.results.certificate.dcc.elements import dsi_unit
from station.results.parameters_by_name import applied, parameters
from tests.empty_database import empty_db
from tests.patience import HANG_S
from tests.station.results.certificate.dcc_kinds import KINDS, content
from tests.station.results.certificate.dcc_numbers import NS, of_type, parsed, read, results
from tests.station.results.certificate.factory import accepted, drifted
from tests.station.results.report import factory

G = 9.80665  # m/s2
IN_SI = {"g": lambda value: value * G, "count/(g s)": lambda value: value / G, "output/g": lambda value: value / G}
Document = dict[str, Any]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> dict[str, tuple[Document, bytes]]:
    """Return calibration and XML of every kind."""
    found = {}
    for number, kind in enumerate(KINDS):
        with empty_db(tmp_path_factory.mktemp("db") / f"{number}.db") as database, database.write() as session:
            before = json.loads(accepted(session, drifted(2.0)).document)
            document = json.loads(KINDS[kind](session).document)
            found[kind] = document, certificate_xml(content(document, previous=before))
    return found


def in_si(unit: str, value: float) -> float:
    return float(IN_SI.get(unit, lambda same: same)(value))


@pytest.mark.parametrize("kind", KINDS)
def test_every_number_is_the_solutions(made: dict[str, tuple[Document, bytes]], kind: str) -> None:
    document, xml = made[kind]
    root, reported = parsed(xml), applied(parameters(document))
    found, budget = results(root), {one["name"]: one for one in document["uncertainty"]["parameters"]}
    assert list(found) == list(reported)
    for name, one in reported.items():
        assert found[name].value == in_si(one.unit, one.value), name
        assert found[name].expanded == in_si(one.unit, budget[name]["expanded"])
        assert found[name].factor == budget[name]["coverage_factor"]
        assert found[name].dof == budget[name].get("dof")
    for parts in of_type(root, "fog_budget", "list"):
        one = budget[parts.get("refId")]
        combined, *contributions = [read(each).value for each in parts.findall("dcc:quantity", NS)]
        assert combined == in_si(one["unit"], one["std"])
        assert contributions == [in_si(one["unit"], part["std"]) for part in one["contributions"]]


def test_the_covariance_matrix_is_the_solutions(made: dict[str, tuple[Document, bytes]]) -> None:
    document, xml = made["twelve positions"]
    solution, reported = factory.solution(), applied(parameters(document))
    at = {name: place for place, name in enumerate(solution.names)}
    factor = {name: in_si(reported[name].unit, 1.0) for name in reported}
    seen = set[tuple[str, str]]()
    for block in of_type(parsed(xml), "fog_covarianceBlock", "quantity"):
        labels = block.findtext(".//si:labelXMLList", None, NS).split()
        values = block.findtext(".//si:valueXMLList", None, NS).split()
        for label, text in zip(labels, values, strict=True):
            row, column = label.split("|")
            exact = solution.covariance[at[row], at[column]]
            if factor[row] == factor[column] == 1.0:
                assert float(text) == exact
            assert float(text) == pytest.approx(exact * factor[row] * factor[column], rel=1e-15)
            seen |= {(row, column), (column, row)}
    known = [name for name in reported if name in at]
    assert seen == {(row, column) for row in known for column in known}


def test_the_calibration_within_is_the_one_whose_hash_is_stated(made: dict[str, tuple[Document, bytes]]) -> None:
    document, xml = made["effects"]
    within = b64decode(parsed(xml).findtext(".//dcc:byteData/dcc:dataBase64", None, NS))
    assert json.loads(within) == document
    assert digest(within.decode()) == digest(canonical(document))


def test_effects_stand_with_their_coefficients(made: dict[str, tuple[Document, bytes]]) -> None:
    [effects] = of_type(parsed(made["effects"][1]), "fog_effects", "result")
    found = [read(one) for one in effects.iterfind(".//dcc:quantity", NS) if one.find("si:real", NS) is not None]
    assert [(one.value, one.unit) for one in found] == [
        (pytest.approx(1.23e-6 / G, rel=1e-15), r"\metre\tothe{-1}\second\tothe{2}"),
        (-0.012, r"\degree\hour\tothe{-1}\kelvin\tothe{-1}"),
        (0.004, r"\degree\hour\tothe{-1}\kelvin\tothe{-1}"),
    ]
    assert "0.5 (ax..az: g/unit), u = 0.1" in etree.tostring(effects, encoding="unicode")


def test_every_unit_is_one_of_the_d_si(made: dict[str, tuple[Document, bytes]]) -> None:
    dsi_unit_library = pytest.importorskip("dsi_unit", reason="dsiUnits is not installed")
    import warnings

    texts = {
        word
        for _, xml in made.values()
        for tag in ("unit", "unitXMLList")
        for one in parsed(xml).iter(f"{{{NS['si']}}}{tag}")
        for word in one.text.split()
    }
    assert len(texts) > 8
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # it warns of \per in units that have none
        assert [text for text in texts if not dsi_unit_library.DsiUnit(text).valid] == []
        assert not dsi_unit_library.DsiUnit(r"\furlong").valid


@pytest.mark.parametrize(
    ("text", "unit", "value"),
    [
        ("g", r"\metre\second\tothe{-2}", G), ("1", r"\one", 1.0), ("deg/h/(K/min)",
         r"\degree\hour\tothe{-1}\kelvin\tothe{-1}\minute", 1.0), ("ppm/(deg/s)^2",
         r"\degree\tothe{-2}\second\tothe{2}", 1e-6), ("count/(g s)", r"\metre\tothe{-1}\second", 1 / G),
        ("g/g^3", r"\metre\tothe{-2}\second\tothe{4}", G**-2),
    ],
)  # fmt: skip
def test_units_of_files_are_turned(text: str, unit: str, value: float) -> None:
    found = dsi_unit(text)
    assert found is not None
    assert found.text == unit
    assert found.of(1.0) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize("text", ["position", "ax..az: g/unit", "g/(", "furlong", "g^x"])
def test_a_unit_that_is_none_is_none(text: str) -> None:
    assert dsi_unit(text) is None


def test_a_foreign_reader_reads_the_same(made: dict[str, tuple[Document, bytes]], tmp_path: Path) -> None:
    pytest.importorskip("dcc_json_toolkit", reason="dccQuantities is not installed")
    (tmp_path / "c.xml").write_bytes(made["effects"][1])
    reader = Path(__file__).with_name("foreign_reader.py")
    command = [sys.executable, str(reader), str(tmp_path / "cache"), str(tmp_path / "c.xml")]
    done = subprocess.run(
        command, capture_output=True, text=True, timeout=HANG_S, check=False, env=dict(os.environ)
    )
    if done.returncode != 0 and any(word in done.stderr for word in ("mono", "clr", "RuntimeError: Fail")):
        pytest.skip("dccQuantities needs mono, which is not here")
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    mine = {one["label"]: one for one in found if "basic_measuredValue" in one["ref_type"]}
    written = results(parsed(made["effects"][1]))
    assert set(mine) == set(written)
    for name, one in written.items():
        assert mine[name]["values"] == [one.value]
        assert one.expanded is not None
        assert one.factor is not None
        assert mine[name]["std"] == [one.expanded / one.factor]
        assert (mine[name]["unit"], mine[name]["is_unit"]) == (one.unit, True)
    blocks = [one for one in found if "fog_covarianceBlock" in one["ref_type"]]
    listed = list(parsed(made["effects"][1]).iter(f"{{{NS['si']}}}valueXMLList"))
    assert [one["values"] for one in blocks] == [[float(word) for word in one.text.split()] for one in listed]
    assert all(one["is_unit"] for one in found)
    assert np.isfinite([value for one in found for value in one["values"]]).all()
