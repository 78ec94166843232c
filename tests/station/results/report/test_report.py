import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from procedures.calibration.solution_values import FitQuality
from procedures.frames import AXES
from station.results.report.report import render, write_report
from station.text import decimals, fixed
from tests.station.results.report import factory

HOSTILE = "<script>alert(1)</script>\"'&$x^2$"


class _Page(HTMLParser):
    """Collects what a page would load, its tags and its text."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.references, self.tags, self.texts, self.ids = list[str](), list[str](), list[str](), list[str]()
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        for name, value in attrs:
            if name in {"src", "href", "xlink:href", "data", "action", "srcset", "poster"}:
                self.references.append(value or "")
            if name == "id":
                self.ids.append(value or "")
            assert not name.startswith("on")

    def handle_data(self, data: str) -> None:
        self.texts.append(data)


@pytest.fixture(scope="module")
def html() -> str:
    return render(factory.report(truth=factory.truth()))


def test_the_report_needs_nothing_but_itself(html: str) -> None:
    page = _Page(html)
    assert all(reference.startswith("#") for reference in page.references)
    assert not {"script", "link", "img", "iframe", "object"} & set(page.tags)
    assert page.tags.count("svg") == 3
    assert re.findall(r"url\((?!#)", html) == []
    assert "@import" not in html
    assert "http" not in html


def test_ids_are_unique_and_every_reference_has_its_target(html: str) -> None:
    page = _Page(html)
    assert len(page.ids) == len(set(page.ids))
    targets = {reference[1:] for reference in page.references} | set(re.findall(r"url\(#([^)]+)\)", html))
    assert targets <= set(page.ids)


def test_every_parameter_is_there_with_its_sigma(html: str) -> None:
    plain = html.replace("\u2007", "").replace("\u2008", "")
    solution = factory.solution()
    for triad, bias_scale in ((solution.accelerometer, 1e6), (solution.gyroscope, 1.0)):
        assert triad is not None
        assert triad.bias_12_position is not None
        for estimate, scale in (
            (triad.scale_factor, 1.0), (triad.bias, bias_scale), (triad.bias_12_position, bias_scale),
        ):  # fmt: skip
            for i in range(3):
                value, std = estimate.value[i] * scale, estimate.std[i] * scale
                next_cell = r'</td>(<td class="num value">[^<]*</td>)?<td class="num( sigma)?">'
                shown = re.escape(fixed(value, decimals(std))), re.escape(fixed(std, decimals(std)))
                assert re.search(f">{shown[0]}{next_cell}{shown[1]}<", plain)
        for q, p in ((0, 1), (1, 0), (2, 1)):
            value, std = triad.misalignment.value[q, p], triad.misalignment.std[q, p]
            arcsec = 180 * 3600 / np.pi
            assert f">{fixed(value * arcsec, decimals(std * arcsec))}</td>" in plain
            assert f">{fixed(value, decimals(std))}({round(std * 10 ** decimals(std))})<" in plain
    assert solution.parallelism is not None
    for value in solution.parallelism.value.ravel() * 180 * 3600 / np.pi:
        assert f">{fixed(value, 3)}<" in plain


def test_the_expanded_uncertainty_stands_next_to_the_value_and_is_that_of_the_budget() -> None:
    first, *others = factory.budgets()
    wide = replace(
        first, expanded=2.04e-6
    )  # g, far above 1 sigma of the fit, as with a time base or a temperature
    page = render(factory.report(budgets=(wide, *others))).replace("\u2007", "").replace("\u2008", "")
    table = page[page.index('aria-label="accelerometer"') :]
    found = re.search(r"<i>D</i><sub>x</sub></span></td>(.*)", table)
    assert found is not None
    triad = factory.solution().accelerometer
    assert triad is not None
    std = triad.bias.std[0] * 1e6
    assert re.findall(r"<td[^>]*>([^<]*)</td>", found[1])[1:3] == ["2.0", fixed(std, decimals(std))]
    assert "Use U when you compare a value with a limit" in page
    assert ">U (95 %)<" in page
    assert ">U (95 %)<" not in render(factory.report())
    assert ">95 % from<" in render(factory.report())


def test_every_residual_and_hash_is_there(html: str) -> None:
    plain = html.replace("\u2007", "").replace("\u2008", "")
    for residual in factory.solution().residuals:
        scale = {"g": 1e6, "deg/h": 1.0, "deg": 3600.0}[residual.unit]
        for i in range(len(AXES)):
            places = decimals(residual.sigma[i] * scale)
            value, limit = (
                fixed(residual.residual[i] * scale, places, sign=True),
                fixed(4 * residual.sigma[i] * scale, places),
            )
            assert f'>{value}</td><td class="num sigma">{limit}<' in plain
    for name, sha256 in factory.FILES.items():
        assert name in html
        assert sha256 in html
    assert "\u25b2 above the limit" in html


def test_conditions_warnings_and_what_is_not_observable_are_there(html: str) -> None:
    solution = factory.solution()
    for text in (*solution.not_observable, *solution.warnings, *solution.unused_steps):
        assert text in html
    for text in ("31.1700", "9.794600", "CUBE-7", "1 of 6 faces", "CMM 2026-01-12", "fog-station 0.1.0", "c0ffee"):
        assert text in html
    for text in ("Angle random walk", "Velocity random walk", "p = 0.25", "\u2713 PASS"):
        assert text in html


def test_equal_reports_give_equal_bytes(tmp_path: Path) -> None:
    for name in ("a.html", "b.html"):
        write_report(tmp_path / name, factory.report())
    assert (tmp_path / "a.html").read_bytes() == (tmp_path / "b.html").read_bytes()


def test_hostile_names_stay_text() -> None:
    campaign = factory.campaign(serial=HOSTILE, model=HOSTILE)
    dwells = tuple(replace(dwell, name=HOSTILE) for dwell in campaign.dwells)
    fixture = replace(campaign.fixture, id=HOSTILE)
    solution = factory.solution()
    residuals = tuple(replace(residual, name=HOSTILE) for residual in solution.residuals)
    solved = replace(solution, warnings=(HOSTILE,), residuals=residuals)
    measured = replace(campaign, dwells=dwells, fixture=fixture)
    document = factory.document(solved, measured, {HOSTILE: "00" * 32}, HOSTILE)
    verdict = replace(factory.VERDICT, reason=HOSTILE)
    page = render(factory.report(solved, measured, made_of=document, verdict=verdict))
    assert "<script" not in page
    assert "script" not in _Page(page).tags
    assert any(HOSTILE in text for text in _Page(page).texts)


def test_a_bare_solution_still_makes_a_report() -> None:
    solution = replace(
        factory.solution(), gyroscope=None, slab_tilt=None, parallelism=None, residuals=(), names=(),
        covariance=np.zeros((0, 0)), reference_temperature=None, quality=FitQuality(0.0, 0, 1.0),
        not_observable=(), warnings=(), unused_steps=(),
    )  # fmt: skip
    campaign = factory.campaign(samples=60)
    assert "Gyroscope, dwells" not in render(factory.report(solution, campaign))
    assert "Noise" not in render(factory.report(solution, replace(campaign, dwells=(), turns=())))


def test_numbers_that_are_not_finite_show_as_a_dash() -> None:
    solution = factory.solution()
    assert solution.slab_tilt is not None
    tilt = replace(solution.slab_tilt, value=np.array([np.nan, 0.0]), std=np.array([np.inf, np.nan]))
    first = replace(solution.residuals[0], sigma=np.array([0.0, np.nan, 1.0]))
    page = render(factory.report(replace(solution, slab_tilt=tilt, residuals=(first,))))
    assert re.search(r"\b(nan|inf)\b", _visible(page).lower()) is None


def _visible(page: str) -> str:
    return " ".join(_Page(re.sub(r"<style.*?</style>", "", page, flags=re.DOTALL)).texts)


def test_the_budget_has_a_line_a_parameter_with_its_largest_contributions() -> None:
    text = render(factory.report(budgets=factory.budgets()))
    table = text[text.index("uncertainty budget of the accelerometer") : text.index("<h2>Residuals")]
    assert table.count("counting noise\u00a084\u00a0%, bias instability\u00a015\u00a0%") == 3
    assert '<td class="num">0.15</td><td>\u00b5g</td><td class="num">1.98</td><td class="num">143</td>' in table
    assert "closure\u00a0100\u00a0%" in table
    assert "\u221e" in table
