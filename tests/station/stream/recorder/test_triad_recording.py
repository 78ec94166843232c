"""Three simulated CH-70 on three ptys, through the reader process, to one recording that its bytes confirm."""

from contextlib import ExitStack
from pathlib import Path

import pytest

from drivers.simulated.server import SimulatedDevice
from drivers.simulated.truth import Truth
from drivers.wire import FORMATS
from station import cli
from station.files.mcap_files import read_step
from station.stream.recorder.raw_check import check_raw_bytes


def test_a_triad_is_recorded_like_one_device(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with ExitStack() as served:
        truth = Truth.example(5)
        devices = [served.enter_context(SimulatedDevice(truth, seed, "ch70", speed=4)) for seed in range(3)]
        ports = [device.url.partition("?")[0] for device in devices]
        url = f"triad:?x={ports[0]}&y={ports[1]}&z={ports[2]}&format=ch70"
        assert cli.run(["record", url, "--seconds", "0.5", "--out", str(tmp_path / "r")]) == 0
    assert "samples of triad" in capsys.readouterr().out
    path = tmp_path / "r/recording.mcap"
    contents = read_step(path)
    assert check_raw_bytes(path, FORMATS["triad"]) == len(contents) >= 90
    assert contents.gyro is not None
    assert (contents.gyro != 0).any(axis=0).all()
    assert contents.accel is None
