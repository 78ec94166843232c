"""`station simulate --gnss` serves an autopilot next to the IMU; the page lists its faults."""

import re
import time
from pathlib import Path

import pytest

from drivers.address_parsing import LINKS
from drivers.mavlink.frames import GPS2_RAW
from drivers.mavlink.gnss_fixes import MavlinkDecoder
from drivers.ports import open_port
from drivers.simulated.companions.gnss_server import SimulatedGnss
from drivers.simulated.companions.truths import AutopilotTruth
from drivers.simulated.truth import Truth
from procedures.gnss_records import GnssFix
from station import cli
from station.files.mcap_files import read_step
from tests.paths import ROOT
from tests.patience import HANG_S, longer, paced
from tests.station.commands.program import Program

FAULTS = """
[[fault]]
kind = "lost"
at_s = 1
[[gnss_fault]]
kind = "jump"
at_s = 0
seconds = 1e6
size = 5000.0
"""


def test_an_autopilot_is_served_with_the_imu_with_its_own_faults(tmp_path: Path) -> None:
    (tmp_path / "faults").write_text(FAULTS)
    options = ("--speed", f"{paced(50.0):g}", "--gnss", "tcp", "--faults", str(tmp_path / "faults"))
    with Program("simulate", "--example", "7", "--pty", str(tmp_path / "imu"), *options) as program:
        (url,) = re.findall(r"^gnss (\S+)$", "".join(program.until("control ")), re.MULTILINE)
        imu, port = open_port(f"serial://{tmp_path / 'imu'}"), open_port(f"{url}?rate=2")
        decoder, fixes = MavlinkDecoder(), list[GnssFix]()
        deadline = time.monotonic() + HANG_S
        while len(fixes) < 20:
            assert time.monotonic() < deadline
            imu.read(65536)  # its time is theirs: without a reader both stand still
            records = decoder.feed(port.read(65536), time.monotonic_ns())
            fixes += [one for one in records if isinstance(one, GnssFix) and one.has_position]
        imu.close()
        port.close()
    east = (fixes[-1].longitude or 0.0) * 6.378e6 * 0.8557 - 121.4 * 0.0174533 * 6.378e6 * 0.8557
    assert east == pytest.approx(5000.0, abs=60.0)


@pytest.mark.parametrize("link", ["bluetooth", "udp:x", "udpto:9"])
def test_a_link_that_there_is_not_is_refused(link: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.run(["simulate", "--example", "7", "--gnss", link]) == 2
    assert "udp[:PORT]" in capsys.readouterr().err


def test_devices_says_who_is_on_a_link_and_what_was_answered(capsys: pytest.CaptureFixture[str]) -> None:
    autopilot = AutopilotTruth(system=5, denies=frozenset({GPS2_RAW}))
    with SimulatedGnss(Truth(), autopilot, speed=10.0) as gnss:
        assert cli.run(["devices", "--url", f"{gnss.url}?rate=2", "--seconds", f"{longer(1.5):g}"]) == 0
    reported = capsys.readouterr().out
    assert re.search(r"system 5: \d\d+ frames", reported)
    assert "GPS_RAW_INT at 2 Hz: accepted" in reported
    assert "GPS2_RAW at 2 Hz: denied" in reported
    assert cli.run(["devices", "--url", "mavlink:udpin:127.0.0.1:0x"]) == 2
    assert "udpin" in capsys.readouterr().err


def test_a_track_carries_the_imu_along_and_one_that_is_over_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "t.csv").write_text("t_s,e_m,n_m,u_m\n" + "".join(f"{t},{t * t},0,0\n" for t in range(40)))
    options = ("--speed", f"{paced(20.0):g}", "--track", str(tmp_path / "t.csv"), "--pty", str(tmp_path / "imu"))
    with Program("simulate", "--example", "7", *options) as program:
        program.until("control ")
        url = f"serial://{tmp_path / 'imu'}?format=counts"
        assert cli.run(["record", url, "--out", str(tmp_path / "r"), "--seconds", "5"]) == 0
    step = read_step(tmp_path / "r" / "recording.mcap")
    ahead = step.accel[:, 0].mean() / 0.02 / 1000  # 2 m/s2
    assert ahead == pytest.approx(2.0 / 9.80665, abs=0.02)
    (tmp_path / "t.csv").write_text("t_s,e_m,n_m,u_m\n-9,0,0,0\n-8,1,0,0\n")
    assert cli.run(["simulate", "--example", "7", "--track", str(tmp_path / "t.csv")]) == 3
    assert "a track that ended at -8 s" in capsys.readouterr().err


PAGE = (ROOT / "docs/how-to/gnss.md").read_text(encoding="utf-8")


def test_every_link_is_on_the_page() -> None:
    assert all(f"`mavlink:{link}:" in PAGE for link in LINKS)
