"""``--plain``: it ends where nobody can type, asks again where somebody can, and says what can be typed."""

import os
import pty
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from drivers.simulated.server import SimulatedDevice
from drivers.simulated.truth import Truth
from station.files.campaign_setup import Setup
from station.guide.plain_screen import command_of
from station.guide.setup_view import StartView
from station.guide.view import CalibrationView, OperatorCommand
from tests.station.commands.program import STATION, Program

REFUSED = CalibrationView(stage="start", start=StartView(refused="/dev/x: no such port", refused_code=4))
BEGIN = OperatorCommand(verb="begin", setup=Setup(url="/dev/x", latitude_deg=31.0))


def plain(url: str, folder: Path, *more: str) -> tuple[str, ...]:
    where = ("--latitude", "31.17", "--out", str(folder / "c"), "--db", str(folder / "s.db"))
    return ("calibrate", "--plain", "--device", url, *where, *more)


@pytest.mark.parametrize("input_is", ["at its end", "open but no terminal"])
def test_a_port_that_does_not_exist_ends_it_with_exit_4(tmp_path: Path, input_is: str) -> None:
    with Program(*plain("/dev/ttyNONE", tmp_path)) as program:
        assert program.process.stdin is not None
        if input_is == "at its end":
            program.process.stdin.close()
            program.process.stdin = None
        assert program.process.wait() == 4
    assert not (tmp_path / "c").exists()


def test_a_database_that_is_none_ends_it_with_exit_2_and_no_traceback(tmp_path: Path) -> None:
    (tmp_path / "s.db").write_text("no database")
    with Program(*plain("/dev/ttyNONE", tmp_path)) as program:
        code, _, error = program.end()
    assert (code, error.count("\n")) == (2, 1)


@contextmanager
def at_a_terminal(*arguments: str) -> Iterator[tuple[int, "subprocess.Popen[bytes]"]]:
    ours, theirs = pty.openpty()
    program = subprocess.Popen(
        [sys.executable, "-P", "-c", STATION, *arguments], stdin=theirs, stdout=theirs, stderr=theirs,
        start_new_session=True,
    )  # fmt: skip
    os.close(theirs)
    try:
        yield ours, program
    finally:
        program.kill()
        program.wait()
        os.close(ours)


def read_until(end: int, text: str) -> str:
    reported = ""
    while text not in " ".join(reported.split()):  # a line ends at the terminal's last column
        reported += os.read(end, 4096).decode()
    return reported


def test_a_person_is_asked_again_and_may_type_another_address(tmp_path: Path) -> None:
    with (
        SimulatedDevice(Truth.example(5), 5) as device,
        at_a_terminal(*plain("/dev/ttyNO", tmp_path)) as (end, it),
    ):
        read_until(end, "q leave")
        os.write(end, b"g\n")
        read_until(end, "q leave")
        os.write(end, f"{device.url}\n".encode())
        read_until(end, "connected: SIM-FOG3 SIM-5")
        os.write(end, b"c\n")
        assert it.wait() == 130


@pytest.mark.parametrize(
    ("typed", "sent"),
    [
        ("g", BEGIN),
        ("", BEGIN),
        ("q", OperatorCommand(verb="leave")),
        ("/dev/ttyUSB1", OperatorCommand(verb="begin", setup=Setup(url="/dev/ttyUSB1", latitude_deg=31.0))),
        ("x", None),
    ],
)
def test_after_a_refusal_a_line_is_another_try(typed: str, sent: OperatorCommand | None) -> None:
    assert command_of(typed, REFUSED, BEGIN) == sent
    first = OperatorCommand(verb="resume", folder="/c")
    assert command_of("can0", REFUSED, first) == OperatorCommand(verb="resume", folder="/c", url="can0")
