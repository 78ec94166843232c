"""`station devices` over several devices at once, each on a real port."""

import json
import os
import signal
from contextlib import closing, suppress
from pathlib import Path
from threading import Event, Thread

import pytest

from drivers.ports import open_port
from drivers.simulated.companions.gnss_server import SimulatedGnss
from drivers.simulated.companions.truths import AutopilotTruth
from drivers.simulated.server import SimulatedDevice
from drivers.simulated.truth import Truth
from station import cli
from station.port_detection import (
    BAUDS,
    SurveyedPort,
    survey,
)
from tests.patience import longer
from tests.station.commands.program import Program


@pytest.mark.simulated_imu(format="counts", speed=20, faults=[{"kind": "bad_crc", "at_s": 0, "every_s": 1}])
@pytest.mark.simulated_can_imu(speed=20)
def test_every_port_says_what_it_looks_like_and_nothing_else_is_asked(
    simulated_imu: SimulatedDevice, simulated_can_imu: SimulatedDevice, capsys: pytest.CaptureFixture[str]
) -> None:
    autopilot = SimulatedGnss(Truth(), AutopilotTruth(system=9), speed=20, transport="pty")
    far, near = os.openpty()
    with autopilot as gnss:
        plain = gnss.url.replace("mavlink:serial:", "serial://")
        urls = [f"serial://{simulated_imu.address}", simulated_can_imu.url, plain, f"serial://{os.ttyname(near)}"]
        look = ["devices", "--json", "--seconds", f"{longer(0.7):g}"]
        code = cli.run([*look, *[word for url in urls for word in ("--url", url)]])
    os.close(far)
    os.close(near)
    assert code == 4  # the last one is silent
    imu, can, mavlink, silent = json.loads(capsys.readouterr().out)["devices"]
    assert (imu["looks_like"], imu["serial"], imu["rate_hz"]) == ("counts", "SIM-1", pytest.approx(50))
    assert imu["url"].endswith("?baud=921600")
    assert imu["errors"]["bad_crc"] >= 5
    assert (can["looks_like"], can["trouble"]) == ("fog-counts", "")
    assert mavlink["url"] == f"{gnss.url}?baud=921600"
    assert set(mavlink["systems"]) == {"9"}
    assert mavlink["messages"]["GPS_RAW_INT"] > 5
    assert silent["trouble"]


def test_bytes_that_look_like_nothing_are_read_at_every_baud_rate() -> None:
    far, near = os.openpty()
    os.set_blocking(far, False)
    stop = Event()

    def babble() -> None:
        while not stop.wait(0.01):
            with suppress(BlockingIOError):
                os.write(far, b"hello")

    speaker = Thread(target=babble)
    speaker.start()
    [found] = survey([SurveyedPort(f"serial://{os.ttyname(near)}")], longer(0.1))
    stop.set()
    speaker.join()
    os.close(far)
    os.close(near)
    assert ", ".join(map(str, BAUDS)) in found.trouble


def test_it_looks_again_and_again_until_ctrl_c(simulated_imu: SimulatedDevice) -> None:
    url = f"serial://{simulated_imu.address}?baud=921600"
    with Program("devices", "--watch", "--json", "--seconds", f"{longer(0.2):g}", "--url", url) as program:
        looks = [json.loads(program.until("devices/1")[-1])["devices"][0] for _ in range(3)]
        program.process.send_signal(signal.SIGINT)
        assert program.end()[0] == 0
    assert {look["looks_like"] for look in looks} == {"counts"}


@pytest.mark.simulated_imu(format="counts", speed=20)
def test_each_of_several_that_comes_at_a_wrong_pace_is_warned_of(
    simulated_imu: SimulatedDevice, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with closing(open_port(simulated_imu.url)) as port:
        (tmp_path / "recorded").write_bytes(b"".join(port.read(4096) for _ in range(20)))
    urls = [simulated_imu.url, f"replay:{tmp_path / 'recorded'}?format=counts"]  # a file comes as fast as it can
    look = ["devices", "--seconds", f"{longer(0.5):g}"]
    assert cli.run([*look, *[word for url in urls for word in ("--url", url)]]) == 0
    lines = capsys.readouterr().out.splitlines()
    (warned,) = [number for number, line in enumerate(lines) if line.startswith("    warning: ")]
    assert "Hz by this computer's clock; check sample period" in lines[warned]
    assert lines[warned + 1].startswith("replay:")
