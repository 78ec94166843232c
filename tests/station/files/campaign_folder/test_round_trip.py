"""What is written is read back: any campaign, CSV or MCAP."""

import tempfile
import tomllib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from procedures.campaign.campaign import (
    Campaign,
    DwellRecord,
    FaceCertificate,
    Fixture,
    MeasuredCube,
    ProcedureSigma,
    Site,
    TurnRecord,
)
from procedures.campaign.measured_cube import NAMES
from procedures.counts.sample_records import CountSeries, RateSeries, Series
from procedures.positions import FACES, TURN_START
from station.files.campaign_folder.campaign_reading import read_campaign
from station.files.campaign_folder.loaded_campaign import LoadedCampaign
from station.files.toml_file import toml_text
from tests.station.campaign_writing import write_campaign

PERIOD = 0.02
texts = st.text(st.characters(exclude_categories=["Cs"]), max_size=20)
_seen = st.characters(exclude_categories=["Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp"], exclude_characters="/\\.")
names = st.text(_seen, min_size=1, max_size=20).filter(lambda name: name == name.strip())


@st.composite
def series(draw: st.DrawFn, first: int, counts: bool) -> Series:
    n = draw(st.integers(1, 12))
    steps = draw(st.lists(st.sampled_from([1, 1, 1, 3]), min_size=n - 1, max_size=n - 1))
    ticks = np.concatenate(([0], np.cumsum(steps, dtype=int)))
    t = np.round(first + PERIOD * ticks, 9)
    starts = np.concatenate(([0], np.flatnonzero(np.diff(ticks) > 1) + 1))
    cell = st.integers(-(2**40), 2**40) if counts else st.floats(-1e6, 1e6)
    dtype = np.int64 if counts else np.float64
    table = st.lists(st.tuples(cell, cell, cell), min_size=n, max_size=n).map(lambda v: np.array(v, dtype=dtype))
    gyro = draw(st.one_of(st.none(), table))
    accel = draw(table if gyro is None else st.one_of(st.none(), table))
    temperature = np.array(draw(st.lists(st.floats(-80, 200) | st.just(np.nan), min_size=n, max_size=n)))
    more_columns = st.lists(st.floats(-1e9, 1e9) | st.just(np.nan), min_size=n, max_size=n).map(np.array)
    extra = draw(st.dictionaries(st.sampled_from(["aux_load", "utc_s"]), more_columns))
    kind = CountSeries if counts else RateSeries
    return kind(t, gyro, accel, temperature, PERIOD, starts, extra)


@st.composite
def measured_cubes(draw: st.DrawFn) -> MeasuredCube:
    some = tuple(draw(st.lists(st.sampled_from(NAMES), min_size=1, unique=True)))
    value = np.array(draw(st.lists(st.floats(-1e-3, 1e-3), min_size=len(some), max_size=len(some))))
    root = np.tril(np.full((len(some), len(some)), draw(st.floats(-1e-6, 1e-6))), -1) + 1e-6 * np.eye(len(some))
    return MeasuredCube(some, value, root @ root.T, tuple(draw(st.lists(names, max_size=2))))


@st.composite
def campaigns(draw: st.DrawFn) -> Campaign:
    counts = draw(st.booleans())
    positions = draw(st.lists(st.integers(1, 12), min_size=1, max_size=4))
    dwells = tuple(
        DwellRecord(f"dwell_{i}", p, draw(series(100 * i, counts))) for i, p in enumerate(positions, start=1)
    )
    axes = draw(st.lists(st.sampled_from("xyz"), max_size=2))
    turns = tuple(
        TurnRecord(f"turn_{i}", a, draw(st.sampled_from("+-")), draw(st.integers(1, 9)), TURN_START[a],
                   draw(series(1000 * i, counts)))
        for i, a in enumerate(axes, start=1)
    )  # fmt: skip
    tilt = st.floats(-1e-3, 1e-3)
    faces = {
        face: FaceCertificate(
            np.array(draw(st.tuples(tilt, tilt))), np.diag([draw(st.floats(1e-14, 1e-8)), 1e-12])
        )
        for face in draw(st.lists(st.sampled_from(FACES), unique=True))
    }
    measured = None if faces else draw(st.none() | measured_cubes())
    sign = draw(st.sampled_from([1.0, -1.0]))
    axes_of_imu = np.roll(np.eye(3), draw(st.integers(0, 2)), axis=0) * np.array([sign, sign, 1.0])
    return Campaign(
        draw(names), draw(names), counts,
        Site(draw(st.floats(-1.5, 1.5)), draw(st.floats(9.7, 9.9)), draw(st.floats(1e-9, 1e-3)),
             draw(st.none() | st.tuples(*[st.floats(-70, 70)] * 3))),
        dwells, turns,
        ProcedureSigma(draw(st.floats(1e-6, 0.1)), draw(st.floats(1e-6, 0.1))),
        Fixture(faces, axes_of_imu, draw(st.none() | names), measured),
    )  # fmt: skip


def assert_same_series(found: Series, written: Series) -> None:
    assert type(found) is type(written)
    assert np.array_equal(found.t, written.t)
    assert np.array_equal(found.temperature, written.temperature, equal_nan=True)
    assert np.array_equal(found.starts, written.starts)
    for a, b in ((found.gyro, written.gyro), (found.accel, written.accel)):
        assert (a is None and b is None) or (a is not None and b is not None and np.array_equal(a, b))
    for name, values in written.extra.items():
        nothing = np.full(len(values), np.nan)  # what an MCAP file has of a channel without a value
        assert np.array_equal(found.extra.get(name, nothing), values, equal_nan=True)


@pytest.mark.parametrize("suffix", [".csv", ".mcap"])
@settings(max_examples=15)
@given(campaign=campaigns())
def test_a_campaign_is_read_back_as_it_was_written(suffix: str, campaign: Campaign) -> None:
    with tempfile.TemporaryDirectory() as folder:
        write_campaign(Path(folder), campaign, PERIOD, suffix)
        found = read_campaign(Path(folder)).campaign
    assert (found.model, found.serial, found.counts) == (campaign.model, campaign.serial, campaign.counts)
    assert found.site.latitude == pytest.approx(campaign.site.latitude, rel=1e-15, abs=1e-300)
    assert (found.site.gravity, found.site.gravity_std) == (campaign.site.gravity, campaign.site.gravity_std)
    assert found.site.magnetic == campaign.site.magnetic
    assert found.sigma.heading == pytest.approx(campaign.sigma.heading, rel=1e-14)
    assert (found.fixture.id, set(found.fixture.faces)) == (campaign.fixture.id, set(campaign.fixture.faces))
    assert np.array_equal(found.fixture.C_sb, campaign.fixture.C_sb)
    was, read = campaign.fixture.measured, found.fixture.measured
    assert (was is None) == (read is None)
    if was is not None and read is not None:
        assert (read.names, read.units) == (was.names, was.units)
        assert np.array_equal(read.value, was.value)
        assert np.array_equal(read.covariance, was.covariance)
    for face, certificate in campaign.fixture.faces.items():
        assert np.array_equal(found.fixture.faces[face].up_tilt, certificate.up_tilt)
        assert np.array_equal(found.fixture.faces[face].covariance, certificate.covariance)
    for a, b in zip(found.dwells, campaign.dwells, strict=True):
        assert (a.name, a.position) == (b.name + suffix, b.position)
        assert_same_series(a.series, b.series)
    for c, d in zip(found.turns, campaign.turns, strict=True):
        for field in ("axis", "direction", "revolutions", "start_position"):
            assert getattr(c, field) == getattr(d, field)
        assert_same_series(c.series, d.series)


@given(
    st.dictionaries(
        st.from_regex(r"[a-z_]{1,8}", fullmatch=True), texts | st.floats(allow_nan=False) | st.integers()
    )
)
def test_toml_is_read_back_as_it_was_written(table: dict[str, str | float | int]) -> None:
    assert tomllib.loads(toml_text({"t": table})) == {"t": table}


def test_an_mcap_folder_reads_to_the_numbers_of_its_csv_twin(shared_data: Path, tmp_path: Path) -> None:
    csv: LoadedCampaign = read_campaign(shared_data / "campaigns/clean")
    write_campaign(tmp_path, csv.campaign, PERIOD, ".mcap")
    mcap = read_campaign(tmp_path)
    assert mcap.warnings == csv.warnings
    for a, b in zip(mcap.campaign.dwells, csv.campaign.dwells, strict=True):
        assert_same_series(a.series, b.series)
        assert a.series.period == b.series.period
    for c, d in zip(mcap.campaign.turns, csv.campaign.turns, strict=True):
        assert_same_series(c.series, d.series)
