"""`station stream` on simulated devices over ptys and TCP: what comes out, what is refused, how it ends."""

import json
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from drivers.framing import Decoder
from drivers.simulated.companions.gnss_server import SimulatedGnss
from drivers.simulated.companions.truths import EPOCH_UTC
from drivers.simulated.faults import Fault
from drivers.simulated.server import SimulatedDevice
from drivers.simulated.truth import Truth
from drivers.wire import FORMATS
from station import cli
from station.calibration import load
from station.files.mcap_files import read_step
from station.files.mcap_files.schemas import COLUMNS
from station.sending.to_udp import DATAGRAM
from tests.patience import paced
from tests.station.commands.program import STATION, Program
from tests.station.monitor.unit import write_calibration
from tests.station.sending.datagrams import listener

UNIT = replace(Truth.example(5), sample_period_s=0.02)
SPEED = 20.0


@pytest.fixture
def device() -> Iterator[SimulatedDevice]:
    with SimulatedDevice(UNIT, 5, speed=paced(SPEED)) as served:
        yield served


@pytest.fixture
def calibration(tmp_path: Path) -> str:
    return str(write_calibration(tmp_path, UNIT))


def lines_of(text: str) -> list[dict[str, Any]]:
    """Return the lines without what is said of a device that goes faster than time, which shows after 5 s."""
    lines = [json.loads(line) for line in text.splitlines()]
    for line in lines:
        line["flags"] = [flag for flag in line.get("flags", ()) if flag != "clock_off"]
    return lines


def test_lines_hold_what_the_library_makes_of_the_bytes_that_came(
    device: SimulatedDevice, calibration: str, tmp_path: Path
) -> None:
    folder = tmp_path / "r"
    with Program(
        "stream", device.url, "--calibration", calibration, "--seconds", "20", "--folder", str(folder)
    ) as program:
        code, out, reported = program.end()
    lines = lines_of(out)
    assert code == 0
    assert (n := len(lines)) >= 1000
    assert [line["sequence"] for line in lines] == list(range(n))
    assert [line["flags"] for line in lines] == [["begun_anew"], *[[]] * (n - 1)]
    (recording,) = folder.iterdir()
    block = Decoder(FORMATS["counts"]).feed(b"".join(data for _, data in read_step(recording).raw))
    rows = np.searchsorted(block.device_time, [line["t_s"] for line in lines])
    counts = np.hstack((block.gyro, block.accel))[rows]
    t, period = block.device_time[rows], UNIT.sample_period_s
    received = load(calibration).apply(counts, t, block.temperature[rows], period=period)
    expected = np.hstack((received.specific_force, received.angular_rate))
    found = np.array([[line[name] for name in COLUMNS] for line in lines])
    assert [line["t_s"] for line in lines] == t.tolist()
    assert np.abs(found - expected).max() <= 1e-12 * np.abs(expected).max()
    assert "SIM-FOG3 SIM-5, 50 samples/s, calibration calibration.json" in reported
    assert reported.splitlines()[-1] == f"{n} samples, 0 lost, 0 gaps; stdout: 0 samples dropped"
    again = ["stream", f"replay:{recording}", "--speed", "0", "--calibration", calibration]
    with Program(*again) as program:
        replayed = {line["t_s"]: line for line in lines_of(program.end()[1])}
    assert [replayed[line["t_s"]]["omega_x_rad_s"] for line in lines] == found[:, 3].tolist()
    out = tmp_path / "applied.npz"
    assert cli.run(["apply", str(folder), "--calibration", calibration, "--out", str(out)]) == 0
    with np.load(out) as arrays:
        rows = np.searchsorted(arrays["t_s"], t)
        assert np.array_equal(arrays["t_s"][rows], t)
        again_found = np.column_stack([arrays[name] for name in COLUMNS])[rows]
    assert np.abs(again_found - expected).max() <= 1e-9 * np.abs(expected).max()  # the pace of the times, not told


def test_utc_is_the_receivers(
    device: SimulatedDevice, calibration: str, capfd: pytest.CaptureFixture[str]
) -> None:
    with SimulatedGnss(UNIT, imu=device) as gnss:
        asked = ["--calibration", calibration, "--gnss", f"{gnss.url}?rate=20", "--seconds", "60"]
        assert cli.run(["stream", device.url, *asked]) == 0
    lines = [line for line in lines_of(capfd.readouterr().out) if "utc_s" in line]
    assert len(lines) > 100
    off = np.array([line["utc_s"] - EPOCH_UTC - line["t_s"] for line in lines])
    # the device's time is the truth's; a read on a busy machine is late by speed times as much of it
    assert np.median(np.abs(off)) < 0.1 * max(1.0, device.speed)
    assert all("utc_by_messages" in line["flags"] for line in lines)


def test_a_port_that_comes_back_is_gone_on_with(
    calibration: str, capfd: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    unplugged = [Fault("unplug", at_s=20.0, seconds=4.0)]
    link = tmp_path / "imu"  # a reader of /dev/pts/N itself would open what other test got that number
    with SimulatedDevice(UNIT, 5, speed=paced(SPEED), faults=unplugged, link=link) as served:
        assert cli.run(["stream", served.url, "--calibration", calibration, "--seconds", "40"]) == 0
    out, reported = capfd.readouterr()
    lines = lines_of(out)
    restarted = [line["sequence"] for line in lines if "begun_anew" in line["flags"]]
    assert len(restarted) == 2
    assert lines[restarted[1]]["flags"] == ["gap_before", "begun_anew"]
    assert len(lines) >= 2000  # what came in the same read as the last of them is handed on too
    assert [line["sequence"] for line in lines] == list(range(len(lines)))
    assert (
        "well again" in reported or "own time goes at" in reported
    )  # as it says from then on where the machine is slow
    assert " 1 gap;" in reported.splitlines()[-1]


def test_ctrl_c_ends_it_with_its_summary(device: SimulatedDevice, calibration: str) -> None:
    with Program("stream", device.url, "--calibration", calibration) as program:
        program.until('"sequence": 20')
        program.process.send_signal(signal.SIGINT)
        code, _, reported = program.end()
    assert code == 130
    assert reported.splitlines()[-1] == "cancelled"
    assert " 0 samples dropped" in reported.splitlines()[-2]


def test_a_reader_that_leaves_ends_it(device: SimulatedDevice, calibration: str) -> None:
    command = [sys.executable, "-P", "-c", STATION, "stream", device.url, "--calibration", calibration]
    program = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert program.stdout is not None
    program.stdout.readline()
    program.stdout.close()
    assert program.stderr is not None
    reported = program.stderr.read()
    assert program.wait() == 0
    assert "stdout: its reader has left" in reported
    program.stderr.close()


def test_the_monitor_streams_in_addition_to_its_lines(
    device: SimulatedDevice, calibration: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with listener() as bound:
        to = f"udp:127.0.0.1:{bound.getsockname()[1]}"
        folder = str(tmp_path / "r")
        asked = ["--calibration", calibration, "--json", "--folder", folder, "--seconds", "10", "--stream", to]
        assert cli.run(["monitor", device.url, *asked]) == 0
        bound.setblocking(False)
        came = list(iter(lambda: _received(bound), b""))
    rows = np.frombuffer(b"".join(came), DATAGRAM)
    lines = lines_of(capsys.readouterr().out)
    assert rows["sequence"].tolist() == list(range(len(rows)))
    ends = [line for line in lines if line["t_s"] in set(rows["t_s"].tolist())]
    assert len(ends) > 50
    for line in ends:  # forward-right-down, a mean over the tick of five samples
        (at,) = np.flatnonzero(rows["t_s"] == line["t_s"])
        mean = np.degrees(rows["omega_rad_s"][at - 4 : at + 1].mean(axis=0)) * (1, -1, -1)
        assert line["rate_deg_s"] == pytest.approx(mean, abs=1e-5)
    assert "udp:" in (tmp_path / "r" / "events.csv").read_text()


def _received(bound: socket.socket) -> bytes:
    try:
        return bound.recv(4096)
    except BlockingIOError:
        return b""


@pytest.mark.parametrize(
    ("options", "code", "reported"),
    [
        (["--to", "file:x"], 2, "expected one of foxglove"),
        (["--calibration", "GOOD", "--to", "udp:1"], 2, "expected udp:HOST:PORT"),
        (["--frame", "cube"], 2, "expected one of sensor, frd"),
        (["--axes", "x,y,y"], 2, "names an axis twice"),
        (["--nominal", "--calibration", "x"], 2, "expected one of them"),
        ([], 3, "no stored calibration of SIM-FOG3 SIM-5"),
        (["--nominal"], 3, "no nominal scale factors of SIM-FOG3 in format counts"),
        (["--calibration", "NOBODY-1"], 3, "no such file, and no calibration of a unit NOBODY-1"),
        (["--serial", "S9"], 4, "SIM-5 is connected, expected S9"),
        (["--calibration", "OTHER"], 3, "found a calibration of SIM-FOG3 SIM-6, expected one of SIM-FOG3 SIM-5"),
        (["--calibration", "GOOD", "--to", "mavlink:tcp:1.2.3.4:5"], 2, "udpout"),
        (["--calibration", "GOOD", "--to", "udp:nowhere.invalid:5"], 4, "nowhere.invalid:5"),
    ],
)
def test_what_cannot_be_is_one_line(
    options: list[str], code: int, reported: str, device: SimulatedDevice, calibration: str, tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    (tmp_path / "other").mkdir()
    other = write_calibration(tmp_path / "other", replace(UNIT, serial="SIM-6"))
    named = {"OTHER": str(other), "GOOD": calibration}
    options = [named.get(word, word) for word in options]
    to = [] if "--to" in options else ["--to", "udp:127.0.0.1:9"]
    assert cli.run(["stream", device.url, "--db", str(tmp_path / "s.db"), *to, *options]) == code
    error = capsys.readouterr().err
    assert reported in error
    assert error.count("\n") == 1


def test_the_monitors_lines_and_stdout_do_not_go_together(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["monitor", "x:1", "--json", "--stream", "stdout"]) == 2
    assert "monitor's own lines" in capsys.readouterr().err


def test_two_listeners_get_the_same_and_frd_turns_it(device: SimulatedDevice, calibration: str) -> None:
    with listener() as one, listener() as two:
        to = [word for each in (one, two) for word in ("--to", f"udp:127.0.0.1:{each.getsockname()[1]}")]
        asked = ("stream", device.url, "--calibration", calibration, "--seconds", "4", "--frame", "frd", *to)
        assert cli.run(list(asked)) == 0
        both = [np.frombuffer(b"".join(each.recv(96) for _ in range(200)), DATAGRAM) for each in (one, two)]
    first, second = both
    names = [name for name in DATAGRAM.names or () if name not in {"run", "utc_s"}]
    assert all((first[name] == second[name]).all() for name in names)
    up = np.abs(first["f_m_s2"].mean(axis=0)).argmax()
    signs = (1.0, -1.0, -1.0)  # of forward, right, down along IMU x, y, z
    assert signs[up] * first["f_m_s2"][:, up].mean() == pytest.approx(9.8, abs=0.3)
