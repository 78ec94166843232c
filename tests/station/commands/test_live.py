"""Whole programs on simulated devices over ptys."""

import json
import os
import re
import signal
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from sqlalchemy import text

from drivers.ports import open_port
from drivers.simulated.server import SimulatedDevice
from drivers.simulated.truth import Truth
from drivers.wire import FORMATS
from fixtures_db.campaigns import campaign
from fixtures_db.database import open_db
from fixtures_db.stored_calibrations import history, verify_chain
from station import cli
from station.files.campaign_folder.campaign_reading import read_campaign
from station.files.mcap_files import read_step
from station.files.sha256sums import verify_folder
from station.stream.recorder.sample_stream import check_raw_bytes
from tests.patience import paced
from tests.station.commands.program import Program

SPEED = 100.0


@pytest.fixture
def device() -> Iterator[SimulatedDevice]:
    with SimulatedDevice(replace(Truth.example(5), sample_period_s=0.05), 5, speed=paced(SPEED)) as served:
        yield served


def calibrate(device: SimulatedDevice, folder: Path) -> tuple[str, ...]:
    site = ("--latitude", "31.17", "--gravity", f"{device.truth.local_gravity:.7f}")
    short = ("--dwell-s", "4", "--turns", "1", "--move-s", "5", "--store")
    where = ("--out", str(folder / "c"), "--db", str(folder / "s.db"))
    return ("calibrate", "--headless", "--device", device.url, "--hands", device.control, *site, *short, *where)


def test_a_campaign_over_a_pty_becomes_a_stored_calibration(device: SimulatedDevice, tmp_path: Path) -> None:
    with Program(*calibrate(device, tmp_path)) as program:
        code, reported, error = program.end()
    assert (code, error) == (0, "")
    assert len(re.findall("^accepted: ", reported, re.MULTILINE)) == 19
    assert "NO LIMITS" in reported
    loaded = read_campaign(tmp_path / "c")
    assert (loaded.tables.imu.serial, loaded.tables.imu.sample_period_s) == ("SIM-5", 0.05)
    assert (len(loaded.campaign.dwells), len(loaded.campaign.turns)) == (13, 6)  # position 1 once more
    for name in verify_folder(tmp_path / "c"):
        assert check_raw_bytes(tmp_path / "c" / name, FORMATS["counts"]) > 0
    with open_db(tmp_path / "s.db") as database, database.read() as session:
        [row] = history(session, "SIM-5")
        assert row.document == (tmp_path / "c" / "calibration.json").read_text()
        assert verify_chain(session) == []
    found = json.loads((tmp_path / "c" / "solution.json").read_text())
    k, truth = found["gyroscope"]["scale_factor"], Truth.example(5).gyro_k
    assert all(abs(v - t) < 5 * s for v, s, t in zip(k["value"], k["std"], truth, strict=True))
    assert (tmp_path / "c" / "report.html").read_text().startswith("<!DOCTYPE html>")


def test_ctrl_c_is_130_and_keeps_the_accepted_steps(device: SimulatedDevice, tmp_path: Path) -> None:
    with Program(*calibrate(device, tmp_path)) as program:
        program.until("[3/19]")
        program.process.send_signal(signal.SIGINT)
        code, _, error = program.end()
    assert (code, error) == (130, "cancelled\n")
    names = verify_folder(tmp_path / "c")
    assert len(names) >= 2
    dwells = [name for name in names if not name.startswith("move")]
    assert [d.name for d in read_campaign(tmp_path / "c").campaign.dwells] == dwells
    assert read_step(next((tmp_path / "c").glob("session_*.mcap"))).damage is None


def test_a_kill_in_mid_campaign_keeps_the_accepted_steps(device: SimulatedDevice, tmp_path: Path) -> None:
    with Program(*calibrate(device, tmp_path)) as program:
        program.until("[5/19]")
        program.process.kill()
        program.end()
    dwells = read_campaign(tmp_path / "c").campaign.dwells
    assert [d.position for d in dwells][:4] == [1, 2, 3, 4]
    with open_db(tmp_path / "s.db") as database, database.read() as session:
        assert session.execute(text("PRAGMA integrity_check")).scalar() == "ok"
        rows = [step.file for step in campaign(session, str((tmp_path / "c").resolve())).steps]
    assert rows == [d.name for d in dwells][: len(rows)]  # the kill may fall between the file and the row
    assert set(verify_folder(tmp_path / "c")) >= {d.name for d in dwells}


def test_record_keeps_bytes_and_counts(
    device: SimulatedDevice, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.run(["record", device.url, "--seconds", "20", "--out", str(tmp_path / "r")]) == 0
    assert "0 frames lost" in capsys.readouterr().out
    path = tmp_path / "r" / "recording.mcap"
    assert check_raw_bytes(path, FORMATS["counts"]) >= 400
    assert verify_folder(tmp_path / "r") == ["recording.mcap"]


def device_fault(arguments: list[str], capsys: pytest.CaptureFixture[str], folder: Path) -> str:
    """Return the one line that a device fault says; nothing may be left behind."""
    assert cli.run(arguments) == 4
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "Traceback" not in error
    assert not (folder / "c").exists()
    return error


def arguments_for(url: str, folder: Path) -> list[str]:
    where = ["--out", str(folder / "c"), "--db", str(folder / "s.db")]
    return ["calibrate", "--headless", "--device", url, "--latitude", "31", *where]


def test_a_busy_port_is_exit_4(
    device: SimulatedDevice, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    port = open_port(device.url)
    assert device.url.partition("?")[0].removeprefix("serial://") in device_fault(
        arguments_for(device.url, tmp_path), capsys, tmp_path
    )
    port.close()


def test_a_silent_port_is_exit_4(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    far, near = os.openpty()
    for options in ("?format=counts", ""):
        url = f"serial://{os.ttyname(near)}{options}"
        assert "1.8 s" in device_fault(arguments_for(url, tmp_path), capsys, tmp_path)
    os.close(far)
    os.close(near)


def test_the_wrong_format_is_exit_4_and_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with SimulatedDevice(Truth.example(5), 5, "rawimusx", paced(SPEED)) as device:
        url = device.url.replace("rawimusx", "counts")
        reported = device_fault(arguments_for(url, tmp_path), capsys, tmp_path)
    assert "rawimusx" in reported


def test_the_serial_number_of_a_device_that_does_not_send_it_must_be_specified(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with SimulatedDevice(Truth.example(5), 5, "rawimusx", paced(SPEED)) as device:
        reported = device_fault(arguments_for(device.url, tmp_path), capsys, tmp_path)
    assert "--serial" in reported
