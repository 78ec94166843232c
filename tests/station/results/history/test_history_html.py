"""A page that needs nothing else, opens in a browser, and shows every parameter."""

import json
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from fixtures_db.model_limits import Limit, each_axis
from station.results.history.history_html import history_page
from station.results.history.population import population_document
from station.results.history.unit_history import analysis, entries
from tests.station.results.history.fleets import MODEL, fleet

LIMITS = each_axis(Limit("accelerometer.bias", -2e-3, 2e-3, "g"))


def unit_document(each: int) -> dict[str, object]:
    runs = fleet(np.random.default_rng(2), units=1, each=each)
    together = [analysis(runs, LIMITS, None)]
    return {"format": "history/1", "serial": "S<0>", "calibrations": entries(runs), "analysis": together}


@pytest.fixture(scope="module")
def pages() -> dict[int, str]:
    return {each: history_page(unit_document(each)) for each in (1, 5)}


@pytest.mark.parametrize("each", [1, 5])
def test_a_units_page_is_self_contained_and_has_a_chart_of_every_kind(pages: dict[int, str], each: int) -> None:
    text = pages[each]
    assert text.count("<svg") == 6
    assert not re.search(r'(src|href)="(?!#)', text)
    assert "S&lt;0&gt;" in text
    assert not re.search(r"\bnan\b", text)
    assert ("too few calibrations" in text) == (each == 1)


def test_a_populations_page_names_what_stands_out_in_its_charts() -> None:
    runs = fleet(np.random.default_rng(3), units=10, each=6, off_cube_ug=200.0, off_unit_ug=5000.0)
    text = history_page(json.loads(json.dumps(population_document(MODEL, runs), allow_nan=False)))
    figures = "".join(re.findall(r"<svg.*?</svg>", text, re.DOTALL))
    assert ">S2<" in figures
    assert ">CUBE-2<" in figures
    assert ">CUBE-1<" not in figures


@pytest.mark.skipif(shutil.which("chromium") is None, reason="no chromium on this machine")
def test_a_browser_draws_it(tmp_path: Path, pages: dict[int, str]) -> None:
    (tmp_path / "h.html").write_text(pages[5])
    command = ["chromium", "--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={tmp_path / 'user'}"]
    shot = tmp_path / "h.png"
    subprocess.run(
        [*command, f"--screenshot={shot}", "--window-size=900,1200", (tmp_path / "h.html").as_uri()],
        check=True, capture_output=True,
    )  # fmt: skip
    assert shot.stat().st_size > 50_000  # an empty page of this size has about 5 kB
