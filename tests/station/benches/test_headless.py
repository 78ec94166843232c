"""The headless bench accepts what rests on the right face, and only that."""

from pathlib import Path

import numpy as np
import pytest

from drivers.simulated.faults import Fault
from drivers.simulated.truth import Truth
from drivers.wire import FORMATS
from procedures.records import CountSeries
from procedures.steps import Dwell, Turn
from station.benches.headless import TurnFailed
from station.campaign_folder import read_campaign, verify_folder
from station.reader import Chunk, GapMark
from station.recorder import UnitChanged, check_raw_bytes
from tests.station.benches.bench_in_memory import InstantHands, Rig

TURN = Turn("x", "+", 3, 1, 5.0)
WIRE = FORMATS["counts"]


def data(series: object) -> CountSeries:
    assert isinstance(series, CountSeries)
    return series


def test_a_dwell_holds_as_many_seconds_as_asked_and_is_on_the_disk(rig: Rig) -> None:
    series = rig.bench.perform(Dwell(3, 12.5))
    assert len(series) == 625
    [read] = read_campaign(rig.folder).campaign.dwells
    assert read.position == 3
    assert np.array_equal(data(read.series).gyro, series.gyro)
    assert np.array_equal(data(read.series).accel, series.accel)
    assert np.allclose(read.series.t, series.t, rtol=0, atol=1e-9)
    assert check_raw_bytes(rig.folder / "dwell_03.mcap", WIRE) == 625
    assert verify_folder(rig.folder) == ["dwell_03.mcap"]
    assert rig.said[-1].phase == "accepted"


def test_a_turn_has_rest_at_both_ends_and_three_revolutions_between(rig: Rig) -> None:
    series = rig.bench.perform(TURN)
    k = rig.source.device.truth.gyro_k[0]
    turned = series.gyro[:, 0].sum() / k
    assert abs(turned - 1080) < 1
    for end in (series.gyro[:200, 0], series.gyro[-200:, 0]):  # 4 s
        assert abs(end.sum() / k) < 0.1
    assert read_campaign(rig.folder).campaign.turns[0].start_position == 1


def test_the_second_turn_about_an_axis_begins_where_the_first_ended(rig: Rig) -> None:
    commands = list[str]()
    bench = rig.bench_with(InstantHands(rig.source.device, lambda c: commands.append(c)))
    bench.perform(TURN)
    bench.perform(Turn("x", "-", 3, 1, 5.0))
    assert [command.split()[0] for command in commands] == ["place", "turn", "turn"]


def test_the_wrong_face_is_said_and_waited_out(rig: Rig) -> None:
    wrong = iter(["place 7 5"])
    bench = rig.bench_with(InstantHands(rig.source.device, lambda command: next(wrong, None)))
    step = Dwell(1, 5.0)

    def correct(progress: object) -> None:
        rig.said.append(progress)  # type: ignore[arg-type]
        if len(rig.notes(step)) == 5:
            rig.source.device.obey("place 1 5")

    bench._progress = correct  # noqa: SLF001
    series = bench.perform(step)
    assert "Y points down, expected X points up" in rig.notes(step)
    assert abs(series.accel[:, 0].sum() / 5.0 / rig.source.device.truth.accel_k[0] - 1) < 0.01


def test_a_knock_costs_the_disturbed_seconds_only(rig: Rig) -> None:
    step, knocked = Dwell(1, 20.0), list[float]()

    def knock(progress: object) -> None:
        rig.said.append(progress)  # type: ignore[arg-type]
        if not knocked and rig.said[-1].phase == "dwell" and rig.said[-1].seconds >= 10:
            knocked.append(rig.said[-1].seconds)
            rig.source.device.obey("place 1 1")  # a lift of a second, back to the same face

    rig.bench._progress = knock  # noqa: SLF001
    series = rig.bench.perform(step)
    assert len(series) == 1000
    assert len(series.starts) >= 2
    seconds = [p.seconds for p in rig.said if p.phase == "dwell"]
    assert min(np.diff(seconds)) >= 0  # the bar never falls back
    assert check_raw_bytes(rig.folder / "dwell_01.mcap", WIRE) == 1000
    again = read_campaign(rig.folder).campaign.dwells[0].series
    assert again.starts.tolist() == series.starts.tolist()


def test_a_lost_frame_splits_a_dwell_and_nothing_is_taken_for_zero(tmp_path: Path) -> None:
    rig = Rig(tmp_path, faults=[Fault("lost", at_s=25.006, count=3)])
    series = rig.bench.perform(Dwell(1, 30.0))
    assert len(series.starts) == 2
    assert rig.feed.stream.counters.lost == 3
    assert np.all(series.accel[:, 0] > 10)
    rig.database.close()


def test_a_dwell_across_an_unplug_is_begun_again(tmp_path: Path) -> None:
    rig = Rig(tmp_path, faults=[Fault("unplug", at_s=30.0, seconds=5.0)])
    series = rig.bench.perform(Dwell(1, 30.0))
    assert series.t[0] > 35.0
    assert len(series.starts) == 1
    assert "redo" in {p.phase for p in rig.said}
    rig.database.close()


def test_a_turn_in_which_samples_were_lost_is_done_again(tmp_path: Path) -> None:
    rig = Rig(tmp_path, faults=[Fault("lost", at_s=50.0, count=2)])
    rig.bench.perform(TURN)
    assert "samples were lost while it turned" in rig.notes(TURN)
    rig.database.close()


@pytest.mark.parametrize(
    ("command", "reason"), [("turn x - 3 7", "other way round"), ("turn x + 2 7", "1.33|0.67|2.00 rev|1.")]
)
def test_a_turn_that_is_not_the_one_asked_for_is_refused(rig: Rig, command: str, reason: str) -> None:
    rig.bench.perform(TURN)
    step = Turn("x", "+", 3, 1, 5.0)
    bench = rig.bench
    bench._hands = InstantHands(rig.source.device, lambda _: command)  # noqa: SLF001
    with pytest.raises(TurnFailed, match=reason):
        bench.perform(step)


def test_another_unit_in_mid_campaign_is_refused(rig: Rig) -> None:
    rig.bench.perform(Dwell(1, 5.0))
    other = Truth.example(2)
    device = type(rig.source.device)(other, 1, "counts")
    rig.source.device = rig.hands.device = device
    with pytest.raises(UnitChanged, match="SIM-2 is connected, expected SIM-1"):
        rig.bench.perform(Dwell(2, 5.0))
    assert len(read_campaign(rig.folder).campaign.dwells) == 1


def test_a_technician_is_waited_for_until_the_cube_has_moved(rig: Rig) -> None:
    """Nobody knows when a human is done; the partner of a pair shows the same face before as after."""
    moved = list[float]()

    class Technician(InstantHands):
        def place(self, position: int) -> float | None:
            wanted.append(position)
            return None

    class Late:
        def poll(self, timeout_s: float) -> list[Chunk | GapMark]:
            if wanted and (waited.append(1) or len(waited) > 30):  # 30 s later he gets to it
                rig.source.device.obey(f"place {wanted.pop()} 5")
                moved.append(rig.source.device.imu.done)
                waited.clear()
            return rig.source.poll(timeout_s)

    wanted, waited = list[int](), list[int]()
    rig.feed._source = Late()  # type: ignore[assignment]  # noqa: SLF001
    bench = rig.bench_with(Technician(rig.source.device))
    bench.perform(Dwell(1, 5.0))
    second = bench.perform(Dwell(2, 5.0))
    assert second.t[0] > moved[-1]


def test_a_step_done_again_supersedes_and_keeps_the_old_file(rig: Rig) -> None:
    rig.bench.perform(Dwell(1, 5.0))
    rig.bench.perform(Dwell(1, 5.0))
    assert [d.name for d in read_campaign(rig.folder).campaign.dwells] == ["dwell_01_2.mcap"]
    assert (rig.folder / "dwell_01.mcap").exists()
    assert verify_folder(rig.folder) == ["dwell_01.mcap", "dwell_01_2.mcap"]
