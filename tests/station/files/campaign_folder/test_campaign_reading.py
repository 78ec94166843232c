"""A campaign's folder is read as it stands: counts, rates, times, certificates, and what is warned of."""

from pathlib import Path

import numpy as np
import pytest

from procedures.counts.sample_records import CountSeries
from station.errors import DataRefused
from station.files.campaign_folder.campaign_reading import read_campaign
from station.files.campaign_folder.loaded_campaign import LoadedCampaign, check_for_solve, check_one_unit
from tests.refusals import refused


def edit(folder: Path, name: str, *changes: tuple[str, str]) -> None:
    text = (folder / name).read_text()
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    (folder / name).write_text(text)


def series(loaded: LoadedCampaign) -> CountSeries:
    found = loaded.campaign.dwells[0].series
    assert isinstance(found, CountSeries)
    return found


def test_a_correct_folder_is_read_as_it_stands(folder: Path) -> None:
    loaded = read_campaign(folder)
    one = series(loaded)
    assert one.t.tolist() == [1.0, 1.02, 1.04, 1.06, 1.08]
    assert one.gyro is not None
    assert one.gyro.dtype == np.int64
    assert one.gyro[0].tolist() == [1, 2, -3]
    assert one.starts.tolist() == [0]
    assert one.period == pytest.approx(0.02)
    assert np.all(one.temperature == 23.5)
    assert (loaded.warnings, loaded.unused_steps) == ((), ())
    assert set(loaded.files) == {"campaign.toml", "one.csv", "turn.csv"}
    assert loaded.campaign.turns[0].start_position == 1


def test_certificates_and_axes_are_read(folder: Path) -> None:
    fixture = """[fixture]
id = "CUBE-7"
imu_axes = ["+y", "-x", "+z"]
[[fixture.face]]
resting = "x_up"
up_tilt_rad = [1e-5, -2e-5]
std_rad = 5e-6
[[fixture.face]]
resting = "y_down"
up_tilt_rad = [0, 0]
covariance_rad2 = [[4e-12, 1e-12], [1e-12, 9e-12]]
[[dwell]]"""
    edit(folder, "campaign.toml", ("[[dwell]]", fixture))
    found = read_campaign(folder).campaign.fixture
    assert found.id == "CUBE-7"
    assert found.C_sb.tolist() == [[0, 1, 0], [-1, 0, 0], [0, 0, 1]]
    assert np.allclose(found.faces["x_up"].covariance, np.eye(2) * 25e-12, rtol=1e-12, atol=0)
    assert found.faces["y_down"].covariance[0, 1] == 1e-12


def test_optional_cells_may_be_empty(folder: Path) -> None:
    text = "aux_fan,t_s,utc_s,ax,ay,az,temp_c\r\n,1.0,,1,2,3,\r\n,1.02,1e9,1,2,3,\r\n4,1.04,,1,2,3,20\r\n"
    (folder / "one.csv").write_bytes(text.encode())
    step = read_campaign(folder).steps[0]
    assert step.data is not None
    assert np.array_equal(step.data.series.temperature, [np.nan, np.nan, 20.0], equal_nan=True)
    assert np.array_equal(step.data.series.extra["aux_fan"], [np.nan, np.nan, 4.0], equal_nan=True)
    assert np.array_equal(step.data.series.extra["utc_s"], [np.nan, 1e9, np.nan], equal_nan=True)


def test_steps_the_solve_does_not_use_are_read_and_named(folder: Path) -> None:
    extra = """
[[dwell]]
up = "x_up"
file = "a.csv"
[[dwell]]
attitude = "free"
file = "b.csv"
[[sequence]]
file = "c.csv"
[[soak]]
position = 3
file = "d.csv"
[[rate]]
axis = "z"
file = "rates.csv"
"""
    edit(folder, "campaign.toml", ('file = "turn.csv"\n', 'file = "turn.csv"\n' + extra))
    for index, name in enumerate("abcd"):
        (folder / f"{name}.csv").write_text(f"t_s,gx,gy,gz\n{100 + index},1,2,3\n")
    (folder / "rates.csv").write_text("rate_ref_deg_s,gz,temp_c\n1.5,-100.25,\n-1.5,99,40\n")
    loaded = read_campaign(folder)
    assert loaded.unused_steps == ("rate (rates.csv)", "soak (d.csv)")
    assert [(rest.name, rest.up) for rest in loaded.campaign.rests] == [("a.csv", "x_up"), ("b.csv", None)]
    assert [sequence.name for sequence in loaded.campaign.sequences] == ["c.csv"]
    assert loaded.steps[-2].points["gz"].tolist() == [-100.25, 99.0]
    (table,), (soak,) = loaded.campaign.rate_tables, loaded.campaign.soaks
    assert (table.name, table.axis, table.reference.tolist()) == ("rates.csv", "z", [1.5, -1.5])
    assert table.output[:, 2].tolist() == [-100.25, 99.0]
    assert np.isnan(table.output[:, :2]).all()
    assert (soak.name, soak.position, soak.up, len(soak.series)) == ("d.csv", 3, None, 1)


def test_a_period_off_its_nominal_warns_and_then_is_refused_by_solve(folder: Path) -> None:
    edit(folder, "campaign.toml", ("= 0.02", "= 0.0201"))
    loaded = read_campaign(folder)
    assert loaded.warnings
    check_for_solve(loaded)
    edit(folder, "campaign.toml", ("= 0.0201", "= 0.0204"))
    with refused(DataRefused):
        check_for_solve(read_campaign(folder))
    edit(folder, "campaign.toml", ("= 0.0204", "= 0.01"))
    with refused(DataRefused, None, "0.02 s"):
        check_for_solve(read_campaign(folder))


def test_campaigns_of_two_units_are_not_solved_jointly(folder: Path) -> None:
    first = read_campaign(folder)
    edit(folder, "campaign.toml", ('"S1"', '"S2"'))
    with refused(DataRefused, None, "FOG-3 S2"):
        check_one_unit([first, read_campaign(folder)])
    with refused(DataRefused):  # a recording is not counted twice
        check_one_unit([first, first])


@pytest.mark.parametrize(
    ("name", "steps", "unused"),
    [
        ("campaigns/clean", 18, 0),
        ("campaigns/quadratic_free", 30, 0),
        ("measured/fog_rate_temperature", 1, 1),
        ("measured/xsens_mti", 1, 0),
        ("measured/imucal_six_faces", 9, 0),
        ("measured/ln100_two_positions", 2, 0),
    ],
)
def test_the_shared_folders_are_accepted_and_warned_of_their_gravity_at_most(
    shared_data: Path, name: str, steps: int, unused: int
) -> None:
    loaded = read_campaign(shared_data / name)
    of_another_place = [text for text in loaded.warnings if "gravity_m_s2" in text]  # theirs, and worth a warning
    assert (len(loaded.steps), len(loaded.unused_steps)) == (steps, unused)
    assert list(loaded.warnings) == of_another_place
    check_for_solve(loaded)


def test_reference_time_shows_a_period_off_although_the_devices_own_time_agrees(folder: Path) -> None:
    def with_utc(off: float) -> None:
        lines = ["t_s,gx,gy,gz,ax,ay,az,temp_c,utc_s"]
        lines += [f"{1 + 0.02 * i:.2f},1,2,-3,4,0,-6,23.5,{1.7e9 + 0.02 * i * (1 + off):.6f}" for i in range(200)]
        (folder / "one.csv").write_text("\n".join(lines) + "\n")

    with_utc(5e-4)
    assert not read_campaign(folder).warnings
    with_utc(0.005)
    loaded = read_campaign(folder)
    assert "+0.50%" in loaded.warnings[0]
    check_for_solve(loaded)
    with_utc(0.039)  # a sync line at another rate than the one declared
    with refused(DataRefused, None, "+3.90%"):
        check_for_solve(read_campaign(folder))
    for by in (999.0, -2.0, -1.0):  # milliseconds, backwards, a constant
        with_utc(by)
        loaded = read_campaign(folder)
        assert f"{1 + by:.3g} " in loaded.warnings[0]
        check_for_solve(loaded)
    with_utc(0.25)
    with refused(DataRefused, None, "+25.00%"):
        check_for_solve(read_campaign(folder))
