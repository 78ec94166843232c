"""The site's magnetic field where a folder gives none: published values, the day, and what is said without."""

from dataclasses import replace
from datetime import UTC, date, datetime

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from procedures.campaign.plan_steps import turn_steps
from station.files.campaign_folder.campaign_reading import read_campaign
from station.files.campaign_folder.loaded_campaign import LoadedCampaign
from station.results.diagnosis.magnetic_field import recorded_on, with_magnetic_field, world_magnetic_model
from station.results.diagnosis.model_refinement import refine_model
from tests.station.campaign_writing import write_campaign

TODAY = date(2026, 11, 21)

# A. Chulliat et al., The US/UK World Magnetic Model for 2025-2030, NOAA NCEI 2025, table 6, and the test values of
# that for 2020-2025: day, height [km], latitude, longitude [deg], north, east, down [nT].
PUBLISHED = [
    (date(2025, 1, 1), 0, 80, 0, 6521.6, 145.9, 54791.5),
    (date(2025, 1, 1), 0, 0, 120, 39677.8, -109.6, -10580.2),
    (date(2025, 1, 1), 0, -80, 240, 6117.5, 15751.9, -52022.5),
    (date(2025, 1, 1), 100, 80, 0, 6216.0, 92.4, 52598.8),
    (date(2025, 1, 1), 100, -80, 240, 5907.6, 14780.3, -49540.7),
    (date(2020, 1, 1), 0, 80, 0, 6570.4, -146.3, 54606.0),
    (date(2020, 1, 1), 0, 0, 120, 39624.3, 109.9, -10932.5),
    (date(2020, 1, 1), 100, -80, 240, 5744.9, 14799.5, -49969.4),
    (date(2022, 7, 2), 0, 0, 120, 39684.7, -42.2, -10809.5),  # 2022.5 less 12 h
    (date(2027, 7, 2), 0, 80, 0, 6500.8, 294.5, 54869.4),
    (date(2027, 7, 2), 100, -80, 240, 5984.0, 14760.1, -49317.7),
]


@pytest.mark.parametrize("row", PUBLISHED, ids=str)
def test_the_field_is_the_published_one_east_north_up(
    row: tuple[date, int, int, int, float, float, float],
) -> None:
    day, height_km, latitude, longitude, north, east, down = row
    found = world_magnetic_model(latitude, longitude, 1000.0 * height_km, day)
    assert np.allclose(np.array(found) * 1000, [east, north, -down], atol=0.2)  # half a day moves it by 0.1 nT


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> LoadedCampaign:
    """Read a campaign whose site has a longitude and no field."""
    folder, truth = tmp_path_factory.mktemp("c") / "c", replace(Truth.example(7), sample_period_s=0.05)
    campaign = simulate_campaign(truth, 1, dwell_s=10.0, turns=turn_steps(1, 3.0))
    campaign = replace(campaign, site=replace(campaign.site, magnetic=None))
    write_campaign(folder, campaign, truth.sample_period_s)
    file = folder / "campaign.toml"
    text = file.read_text()
    assert "magnetic_enu_ut" not in text
    file.write_text(text.replace("[site]\n", "[site]\nlongitude_deg = 121.4\n"))
    return read_campaign(folder)


def dated(loaded: LoadedCampaign, utc: float) -> LoadedCampaign:
    """Return a campaign whose first step holds reference time."""
    first = loaded.steps[0]
    assert first.data is not None
    series = first.data.series
    extra = {"utc_s": np.where(np.arange(len(series)) < 3, np.nan, utc + series.t)}  # a receiver without a fix yet
    step = replace(first, data=replace(first.data, series=replace(series, extra=extra)))
    return replace(loaded, steps=(step, *loaded.steps[1:]))


def field_at(loaded: LoadedCampaign, day: date) -> tuple[float, float, float]:
    return world_magnetic_model(loaded.tables.site.latitude_deg, 121.4, loaded.tables.site.height_m, day)


def test_the_day_is_that_of_the_recording(recorded: LoadedCampaign) -> None:
    noon = datetime(2021, 3, 4, 12, tzinfo=UTC).timestamp()
    known = dated(recorded, noon)
    assert recorded_on(known) == date(2021, 3, 4)
    assert with_magnetic_field(known, TODAY).campaign.site.magnetic == field_at(recorded, date(2021, 3, 4))
    assert with_magnetic_field(known, TODAY).warnings == recorded.warnings


def test_without_a_day_the_field_is_todays_and_that_is_reported(recorded: LoadedCampaign) -> None:
    assert recorded_on(recorded) is None
    assert recorded_on(dated(recorded, 0.0)) is None  # seconds from somewhere
    found = with_magnetic_field(recorded, TODAY)
    assert found.campaign.site.magnetic == field_at(recorded, TODAY)
    (reported,) = set(found.warnings) - set(recorded.warnings)
    assert "2026-11-21" in reported
    assert "magnetic_enu_ut" in reported


@pytest.mark.parametrize("day", [date(2031, 5, 1)])
def test_a_day_that_no_model_holds_on_leaves_the_field_open(recorded: LoadedCampaign, day: date) -> None:
    noon = datetime(day.year, day.month, day.day, 12, tzinfo=UTC).timestamp()
    found = with_magnetic_field(dated(recorded, noon), TODAY)
    assert found.campaign.site.magnetic is None
    assert str(day) in found.warnings[-1]
    assert "gyroscope.magnetic" in found.warnings[-1]


def test_a_calibration_s_diagnosis_has_the_field_too(recorded: LoadedCampaign) -> None:
    closed = refine_model([recorded])
    assert closed.diagnosis.before.campaigns[0].site.magnetic is not None
    assert any("no file states its date" in text for text in closed.document["solution"]["warnings"])
