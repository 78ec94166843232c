"""Senders and routers of MAVLink that nobody here has written: MAVSDK's C++ stack, and MAVProxy in between."""

import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from drivers.mavlink.gnss_fixes import MavlinkDecoder
from drivers.port_interface import Port
from drivers.ports import open_port
from procedures.gnss_records import FixType, GnssFix, TimeMark
from tests.free_port import free_udp_port
from tests.patience import HANG_S

MAVPROXY = shutil.which("mavproxy.py") or shutil.which("mavproxy.py", path=str(Path(sys.executable).parent))
SENDER = Path(__file__).with_name("mavsdk_sender.py")


@contextmanager
def running(*command: str, folder: Path) -> Iterator[None]:
    with (folder / "reported").open("w") as reported:
        process = subprocess.Popen(command, stdout=reported, stderr=reported, cwd=folder, stdin=subprocess.DEVNULL)
        try:
            yield
        finally:
            process.kill()
            process.wait()


def hear(port: Port, done: Callable[[MavlinkDecoder, list[GnssFix], list[TimeMark]], bool]) -> list[GnssFix]:
    decoder, fixes, marks = MavlinkDecoder(), list[GnssFix](), list[TimeMark]()
    deadline = time.monotonic() + HANG_S
    while not done(decoder, fixes, marks):
        assert time.monotonic() < deadline, (decoder.framer.counters, decoder.messages, decoder.systems)
        for record in decoder.feed(port.read(65536), time.monotonic_ns()):
            if isinstance(record, GnssFix):
                fixes.append(record)
            elif isinstance(record, TimeMark):
                marks.append(record)
    assert decoder.framer.counters.bad_crc == decoder.framer.counters.unknown == 0
    return fixes


def check(fixes: list[GnssFix]) -> None:
    """MAVSDK was told 47.1234567, 8.7654321 deg, 512.5 m, 3.5 m/s towards 123.4 deg, 0.9 m and 17 satellites."""
    fix = next(one for one in fixes if one.source == "GPS_RAW_INT")
    assert fix.fix is FixType.FIX_3D
    assert fix.latitude == pytest.approx(np.radians(47.1234567), abs=2e-9)
    assert fix.longitude == pytest.approx(np.radians(8.7654321), abs=2e-9)
    assert fix.altitude == pytest.approx(512.5, abs=2e-3)
    assert fix.horizontal_std == pytest.approx(0.9, abs=2e-3)
    assert fix.speed == pytest.approx(3.5, abs=0.02)
    assert fix.course == pytest.approx(np.radians(123.4), abs=1e-3)
    assert fix.satellites == 17


def test_a_sender_made_with_mavsdk_is_read(tmp_path: Path) -> None:
    pytest.importorskip("mavsdk", reason="mavsdk is not installed (test extra)")
    number = free_udp_port()
    port = open_port(f"mavlink:udpin:127.0.0.1:{number}")
    with running(sys.executable, str(SENDER), f"udpout://127.0.0.1:{number}", folder=tmp_path):
        check(hear(port, lambda decoder, fixes, _: decoder.heartbeats > 0 and len(fixes) > 5))
    port.close()


def test_mavproxy_in_between_changes_nothing(tmp_path: Path) -> None:
    pytest.importorskip("mavsdk", reason="mavsdk is not installed (test extra)")
    if MAVPROXY is None:
        pytest.skip("mavproxy.py is not installed (test extra)")
    inner, outer = free_udp_port(), free_udp_port()
    router = (
        sys.executable, "-W", "ignore", MAVPROXY, f"--master=udpin:127.0.0.1:{inner}",
        f"--out=udpout:127.0.0.1:{outer}", "--daemon", "--non-interactive", "--default-modules=",
        f"--state-basedir={tmp_path}",
    )  # fmt: skip
    (tmp_path / "a").mkdir()
    port = open_port(f"mavlink:udpin:127.0.0.1:{outer}?system=1")
    sender = (sys.executable, str(SENDER), f"udpout://127.0.0.1:{inner}")
    with running(*router, folder=tmp_path), running(*sender, folder=tmp_path / "a"):
        check(hear(port, lambda decoder, fixes, _: decoder.heartbeats > 0 and len(fixes) > 5))
    port.close()
