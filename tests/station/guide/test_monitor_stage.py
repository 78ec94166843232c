"""A plan's monitor: the guide reads roll and pitch by two laws, on the screen and in the campaign."""

from collections.abc import Callable
from pathlib import Path

import pytest

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from drivers.wire import WireFormat
from drivers.wire.counts import FORMAT as COUNTS
from procedures.campaign.plan_steps import Dwell, Monitor
from procedures.error_codes import ErrorCode
from station.calibrated.calibration_choice import AppliedCalibration
from station.calibrated.calibration_in_use import InUse
from station.errors import DataRefused
from station.files.campaign_folder.campaign_reading import read_campaign
from station.files.sha256sums import verify_folder
from station.guide import folder_recorder
from station.guide.calibration_so_far import calibration_so_far
from station.guide.instruction_words import instruction
from station.guide.interrupted_campaigns import reopen
from station.guide.monitored_words import laws_in_words
from station.guide.view import CalibrationView
from station.stream.recorder.connected_unit import Unit
from tests.refusals import refused
from tests.station.campaign_writing import write_campaign
from tests.station.guide.rig import GuideRig
from tests.station.monitor.unit import calibration_of

Make = Callable[..., GuideRig]
TRUTH = Truth.example(3)


@pytest.fixture
def calibrated(monkeypatch: pytest.MonkeyPatch) -> None:
    """Have the unit's own truth found as its calibration."""

    def found(folder: Path, database: str, unit: Unit, wire: WireFormat) -> AppliedCalibration:
        return AppliedCalibration(calibration_of(TRUTH), None, InUse("by hand"))

    monkeypatch.setattr(folder_recorder, "calibration_so_far", found)


@pytest.mark.usefixtures("calibrated")
@pytest.mark.parametrize("position", [9, 1])
def test_a_monitor_reads_a_cube_level_in_any_position_and_keeps_what_it_read(rig: Make, position: int) -> None:
    guided = rig([Monitor(1, 20.0, position)], TRUTH)
    assert f"position {position}" in instruction(guided.context.checklist.steps[0])
    guided.hands(f"place {position} 5")
    shown: list[CalibrationView] = []
    guided.run(guided.done(1), lambda view: shown.append(view) if view.monitored else None)
    seen = shown[-1].monitored
    assert seen is not None
    assert seen.calibration == "by hand"
    assert [law.law for law in seen.laws] == ["joint", "mixer"]
    assert "deg apart" in laws_in_words(seen)
    [table] = read_campaign(guided.folder).tables.monitor
    assert (table.position, table.laws, table.calibration) == (position, ["joint", "mixer"], "by hand")
    for angle in (*table.roll_deg, *table.pitch_deg):
        assert abs(angle) < 0.15  # a face and the slab are off by less; noise and the counter's step
    assert table.difference_deg is not None
    assert table.difference_deg < 0.1
    assert len(table.scatter_deg) == 2
    assert table.level_deg is not None
    assert table.g_error_mg is not None
    assert verify_folder(guided.folder) == ["monitor_01.mcap"]


@pytest.mark.usefixtures("calibrated")
def test_it_goes_on_after_a_monitor_and_knows_it_again_after_a_kill(rig: Make) -> None:
    guided = rig([Monitor(1, 10.0, 9, ("mixer",)), Dwell(9, 10.0)], TRUTH)
    guided.hands("place 9 5")
    guided.run(guided.done(2))
    loaded = read_campaign(guided.folder)
    assert [dwell.position for dwell in loaded.campaign.dwells] == [9]  # a monitor's counts are not solved
    assert loaded.unused_steps == ("monitor (monitor_01.mcap)",)
    assert reopen(guided.folder, guided.database).accepted == {"monitor_01": 1, "dwell_09": 1}
    guided.resume()
    assert guided.guide.is_complete


@pytest.mark.usefixtures("calibrated")
def test_what_the_guide_leaves_out_as_disturbed_is_in_no_result(rig: Make) -> None:
    guided = rig([Monitor(1, 30.0, 9)], TRUTH)
    guided.hands("place 9 5")
    hands = ["knock 1 0.3"]

    def knocks(view: CalibrationView) -> None:
        if hands and (view.accepted_s or 0.0) >= 22:
            guided.hands(hands.pop())

    guided.run(guided.done(1), knocks)
    assert not hands
    [table] = read_campaign(guided.folder).tables.monitor
    assert max(table.scatter_deg) < 0.005  # 0.002 without a knock; 0.03 and more where it is read


def test_without_a_calibration_it_says_why_nothing_was_read(rig: Make) -> None:
    guided = rig([Monitor(1, 10.0, 9)], TRUTH)
    guided.hands("place 9 5")
    guided.run(guided.done(1))
    [table] = read_campaign(guided.folder).tables.monitor
    assert table.calibration.startswith("none: ")
    assert table.roll_deg == []


def test_the_campaigns_own_steps_are_the_calibration_as_soon_as_they_determine_one(tmp_path: Path) -> None:
    truth = Truth.example(7)
    folder, database = tmp_path / "c", str(tmp_path / "s.db")
    folder.mkdir()
    write_campaign(folder, simulate_campaign(truth, 7, dwell_s=10.0), truth.sample_period_s)
    unit = Unit(truth.model, truth.serial, truth.sample_period_s)
    found = calibration_so_far(folder, database, unit, COUNTS)
    assert found.in_use.text == "this campaign"
    assert found.document is not None
    for name, k in (("accelerometer", truth.accel_k), ("gyroscope", truth.gyro_k)):
        assert found.document[name]["scale_factor"]["value"] == pytest.approx(k.tolist(), rel=1e-3)
    (folder / "campaign.toml").unlink()
    with refused(DataRefused, ErrorCode.CALIBRATION):
        calibration_so_far(folder, database, unit, COUNTS)
