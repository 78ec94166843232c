"""Steps other than dwells and turns: free positions, soaks while temperature moves, and monitors."""

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from drivers.simulated.bench_in_memory import simulate_campaign
from drivers.simulated.truth import Truth
from drivers.wire import WireFormat
from drivers.wire.counts import FORMAT as COUNTS
from procedures.campaign.plan_steps import Dwell, FreePosition, Monitor, Soak
from procedures.errors import ErrorCode
from procedures.free_positions.free_attitudes import UP_DIRECTIONS, angle_deg, up_vector
from station.calibrated import InUse
from station.calibrated.calibration_choice import AppliedCalibration
from station.errors import DataRefused
from station.files.campaign_folder.campaign_reading import read_campaign
from station.files.sha256sums import verify_folder
from station.guide.campaign.accepted_steps import read_accepted_steps
from station.guide.campaign.folder_recorder import FolderRecorder
from station.guide.campaign.interrupted_campaigns import reopen
from station.guide.view import CalibrationView
from station.guide.wording import filters_in_words, instruction
from station.stream.connected_unit import Unit
from tests.refusals import refused
from tests.station.campaign_writing import write_campaign
from tests.station.guide.rig import GuideRig
from tests.station.monitor.unit import calibration_of

Make = Callable[..., GuideRig]


def free(count: int, seconds: float = 10.0) -> list[FreePosition]:
    return [FreePosition(number, seconds) for number in range(1, count + 1)]


def up_of(rig: GuideRig, name: str) -> np.ndarray:
    return rig.context.gate.way_up(rig.context.free_attitudes[name])


def test_tilted_cubes_are_recorded_each_where_it_is_asked_for(rig: Make) -> None:
    guided = rig(free(3))
    for count in (1, 2, 3):
        tilt = guided.rest(2).tilt
        guided.hands("tilt {} {} {} 8".format(*tilt))
        guided.run(guided.done(count))
        assert angle_deg(up_of(guided, f"free_{count:02d}"), up_vector(tilt)) < 15  # 3 deg an axis, and biases
    loaded = read_campaign(guided.folder)
    assert [(table.attitude, table.file) for table in loaded.tables.dwell] == [
        ("free", "free_01.mcap"), ("free", "free_02.mcap"), ("free", "free_03.mcap"),
    ]  # fmt: skip
    assert [len(one.series) for one in loaded.campaign.rests] == [500] * 3
    assert not any(text.startswith("rejected") for text in guided.texts)


def test_a_face_is_no_free_position_and_says_how_to_tilt(rig: Make) -> None:
    guided = rig(free(1))
    view = guided.rest(30)
    assert view.line.startswith("tilt the cube on an edge, X and Y half up, near 45 deg")
    assert view.hint.endswith("deg from the nearest face, at least 20: tilt it further")
    assert view.gates.is_free
    assert not view.gates.is_right_face
    assert view.done == 0
    guided.hands("place 1 8 0 15 0")
    assert guided.rest(60).done == 0
    assert re.match("1[4-6] deg from the nearest face", guided.view.hint)  # the biases are not known


def test_an_attitude_taken_already_is_reported_and_not_taken_twice(rig: Make) -> None:
    guided = rig(free(2))
    guided.hands("tilt 1 1 0 8")
    guided.run(guided.done(1))
    guided.hands("tilt 1 1 0.1 8")
    view = guided.rest(60)
    assert view.done == 1
    assert view.hint.endswith("deg from an attitude already recorded, at least 20: tilt it in another direction")
    assert view.line.startswith("tilt the cube on an edge, X and Z half up")
    guided.hands("tilt -1 -1 1 8")  # not the one asked for: any other will do
    guided.run(guided.done(2))


def heats(rig: GuideRig) -> Callable[[CalibrationView], None]:
    reported = list[bool]()

    def watch(view: CalibrationView) -> None:
        if view.soak and not reported:
            reported.append(True)
            rig.hands("heat 20 10")

    return watch


def warming_biases() -> Truth:
    drift = {"gyroscope.bias_temperature": dict.fromkeys("xyz", 0.5)}
    drift |= {"accelerometer.bias_temperature": dict.fromkeys("xyz", 1e-3)}
    return replace(Truth.example(3), effects=drift)


@pytest.mark.parametrize("soak", [Soak(1, 60.0, 1), Soak(1, 60.0, up="x_up"), Soak(1, 60.0)], ids=str)
def test_a_soak_records_whatever_temperature_does(rig: Make, soak: Soak) -> None:
    guided = rig([soak], warming_biases())
    if not soak.face:
        guided.hands("tilt 0 1 1 8")
    view = guided.run(lambda v: v.soak is not None and v.soak.left_s < 5, heats(guided))
    assert 18 < view.soak.high_c - view.soak.low_c < 20
    assert "so far), " in view.line
    guided.run(guided.done(1))
    [one] = read_campaign(guided.folder).steps
    assert (one.kind, len(one.data.series)) == ("soak", 3000)
    assert (one.table.position, one.table.up) == (soak.position or None, soak.up or None)
    assert np.ptp(one.data.series.temperature) > 18
    assert not any(text.startswith(("rejected", "still")) for text in guided.texts)


def test_a_dwell_under_the_same_heat_is_not_taken(rig: Make) -> None:
    guided = rig([Dwell(1, 60.0)], warming_biases())
    guided.run(lambda v: v.accepted_s > 5)
    guided.hands("heat 20 10")
    assert guided.rest(70).done == 0


def test_what_is_gone_on_with_knows_the_attitudes_taken_and_the_soaks(rig: Make) -> None:
    guided = rig([*free(1), Soak(1, 10.0, 1), *free(2)[1:]])
    guided.hands("tilt 1 1 0 8")
    guided.run(guided.done(1))
    guided.hands("place 1 8")
    guided.run(guided.done(2))
    assert reopen(guided.folder, guided.database).accepted == {"free_01": 1, "soak_01": 1}
    done = read_accepted_steps(guided.folder)
    assert done.seconds == pytest.approx({"free_01": 10.0, "soak_01": 10.0}, rel=1e-6)
    assert list(done.free_attitudes) == ["free_01"]
    assert angle_deg(guided.context.gate.way_up(done.free_attitudes["free_01"]), up_of(guided, "free_01")) < 0.01


def test_the_ways_wanted_are_far_from_faces_and_from_each_other() -> None:
    ups = [up_vector(tilt) for tilt in UP_DIRECTIONS]
    assert len(ups) == 20
    assert min(angle_deg(up, face * sign) for up in ups for face in np.eye(3) for sign in (1, -1)) > 44
    assert min(angle_deg(one, other) for i, one in enumerate(ups) for other in ups[:i]) > 35


TRUTH = Truth.example(3)


@pytest.fixture
def calibrated(monkeypatch: pytest.MonkeyPatch) -> None:
    """Have the unit's own truth found as its calibration."""

    def found(_: FolderRecorder, unit: Unit, wire: WireFormat) -> AppliedCalibration:
        return AppliedCalibration(calibration_of(TRUTH), None, InUse("by hand"))

    monkeypatch.setattr(FolderRecorder, "interim_calibration", found)


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
    assert [one.name for one in seen.filters] == ["joint", "mixer"]
    assert "deg apart" in filters_in_words(seen)
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
    hands = ["shock 1 0.3"]

    def shocks(view: CalibrationView) -> None:
        if hands and (view.accepted_s or 0.0) >= 22:
            guided.hands(hands.pop())

    guided.run(guided.done(1), shocks)
    assert not hands
    [table] = read_campaign(guided.folder).tables.monitor
    assert max(table.scatter_deg) < 0.005  # 0.002 without a knock; 0.03 and more where it is read


def test_the_campaigns_own_steps_are_the_calibration_as_soon_as_they_determine_one(tmp_path: Path) -> None:
    truth = Truth.example(7)
    folder, database = tmp_path / "c", str(tmp_path / "s.db")
    folder.mkdir()
    write_campaign(folder, simulate_campaign(truth, 7, dwell_s=10.0), truth.sample_period_s)
    unit = Unit(truth.model, truth.serial, truth.sample_period_s)
    recorder = FolderRecorder(SimpleNamespace(folder=folder, database_url=database))  # type: ignore[arg-type]
    found = recorder.interim_calibration(unit, COUNTS)
    assert found.in_use.text == "this campaign"
    assert found.document is not None
    for name, k in (("accelerometer", truth.accel_k), ("gyroscope", truth.gyro_k)):
        assert found.document[name]["scale_factor"]["value"] == pytest.approx(k.tolist(), rel=1e-3)
    (folder / "campaign.toml").unlink()
    with refused(DataRefused, ErrorCode.CALIBRATION):
        recorder.interim_calibration(unit, COUNTS)
