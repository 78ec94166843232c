"""`station record` says what is wrong on a line as it appears, and when it is over."""

import signal
from pathlib import Path

from drivers.simulated.server import SimulatedDevice
from drivers.simulated.truth import Truth
from station.stream.recorder.plain_recording import RECORDING_FILE
from tests.patience import until
from tests.station.commands.program import Program

SOME_SAMPLES = 3_000  # bytes of a recording: what describes it, and half a second


def test_a_port_that_went_and_came_back_is_reported_while_it_is_away(tmp_path: Path) -> None:
    link, recording = tmp_path / "imu", tmp_path / "r" / RECORDING_FILE
    with SimulatedDevice(Truth.example(2), 2, link=link) as imu:
        url = f"serial://{link}?format=counts"
        with Program("record", url, "--out", str(tmp_path / "r")) as program:
            until(lambda: recording.is_file() and recording.stat().st_size > SOME_SAMPLES)
            imu.plant("unplug", seconds=3.0)
            assert program.process.stderr is not None
            lines = [program.process.stderr.readline() for _ in range(2)]
            program.process.send_signal(signal.SIGINT)
            _, reported, _ = program.end()
    assert str(link) in lines[0]
    assert "well again" in lines[1]
    assert " 1 gap " in reported
