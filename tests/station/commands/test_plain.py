"""``--plain``: it ends where nobody can type, asks again where somebody can, and says what can be typed."""

import os
import pty
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from drivers.simulated.line_faults import Fault
from drivers.simulated.server import SimulatedDevice
from drivers.simulated.truth import Truth
from station.files.setup import Setup
from station.guide.command import OperatorCommand
from station.guide.setup_view import Readiness, StartView
from station.guide.text_lines import KEYS_HELP, PlainScreen, between_words, command_of, shown_at_end
from station.guide.view import CalibrationView, StageName, Verdict
from station.stream.stream_events import Event
from tests.station.commands.program import STATION, Program

REFUSED = CalibrationView(stage="start", start=StartView(refused="/dev/x: no such port", refused_code=4))
BEGIN = OperatorCommand(verb="begin", setup=Setup(url="/dev/x", latitude_deg=31.0))
VERDICT = CalibrationView(
    stage="verdict",
    verdict=Verdict(
        word="PASS", sentence="PASS", status="calibrated", diagnosis_text="all of it", report="/r.html"
    ),
)


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
        assert program.process.stderr is not None
        assert program.process.stderr.read().startswith("/dev/ttyNONE: no such port, expected a device there; ")
    assert not (tmp_path / "c").exists()


def test_garbled_bytes_end_it_with_exit_4(tmp_path: Path) -> None:
    with SimulatedDevice(Truth.example(5), 5, faults=[Fault("noise", at_s=0.0, seconds=1e6)]) as device:
        with Program(*plain(device.url, tmp_path)) as program:
            assert program.process.wait() == 4


def test_a_database_that_is_none_ends_it_with_exit_2_and_no_traceback(tmp_path: Path) -> None:
    (tmp_path / "s.db").write_text("no database")
    with Program(*plain("/dev/ttyNONE", tmp_path)) as program:
        code, _, error = program.end()
    assert code == 2
    assert "cannot be opened as a database" in error
    assert error.count("\n") == 1


def test_hands_that_do_not_answer_end_it_with_exit_4(tmp_path: Path) -> None:
    with SimulatedDevice(Truth.example(5), 5) as device:
        with Program(*plain(device.url, tmp_path, "--no-warm-up", "--hands", "127.0.0.1:9")) as program:
            code, _, error = program.end()
    assert code == 4
    assert error.startswith("127.0.0.1:9: 'time' found 'Connection refused', expected an answer")


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
    said = ""
    while text not in " ".join(said.split()):  # a line ends at the terminal's last column
        said += os.read(end, 4096).decode()
    return said


def test_a_person_is_asked_again_and_may_type_another_address(tmp_path: Path) -> None:
    with (
        SimulatedDevice(Truth.example(5), 5) as device,
        at_a_terminal(*plain("/dev/ttyNO", tmp_path)) as (end, it),
    ):
        assert "g try again" in read_until(end, "q leave: nothing was recorded")
        os.write(end, b"g\n")
        read_until(end, "q leave: nothing was recorded")
        os.write(end, f"{device.url}\n".encode())
        read_until(end, "connected: SIM-FOG3 SIM-5")
        os.write(end, b"c\n")
        assert it.wait() == 130


def test_a_person_may_leave_after_a_refusal(tmp_path: Path) -> None:
    with at_a_terminal(*plain("/dev/ttyNO", tmp_path)) as (end, program):
        read_until(end, "q leave: nothing was recorded")
        os.write(end, b"q\n")
        assert program.wait() == 130


def test_what_was_refused_is_said_each_time_and_only_to_somebody_who_can_type() -> None:
    said = list[str]()
    screen = PlainScreen(said.append, rings=False, asks=True)
    assert REFUSED.start is not None
    again = REFUSED.model_copy(update={"start": REFUSED.start.model_copy(update={"refusals": 1})})
    for view in (REFUSED, REFUSED, CalibrationView(stage="connecting", line="connecting"), again, again):
        screen.show(view)
    assert [text.split("\n")[0] for text in said] == [f"refused: {REFUSED.start.refused}", "connecting",
                                                      f"refused: {REFUSED.start.refused}"]  # fmt: skip
    PlainScreen(pytest.fail, rings=False).show(REFUSED)


def test_a_person_is_told_the_keys_and_how_it_can_end_once() -> None:
    ready = Readiness(can_pass=True, can_certify=True)
    ends = Event(number=1, sound="", text="this run " + ", ".join(ready.said))
    view = CalibrationView(stage="place", unit="SIM-FOG3 SIM-7", readiness=ready, events=(ends,))
    for asks in (True, False):
        said = list[str]()
        screen = PlainScreen(said.append, rings=False, asks=asks)
        for each in (view, view.model_copy(update={"hint": "slowly"})):
            screen.show(each)
        assert sum(text.count("can end in PASS") for text in said) == 1
        assert said.count(KEYS_HELP) == asks


@pytest.mark.parametrize(
    ("stage", "typed", "verb"),
    [
        ("warm_up", "s", "skip_warm_up"), ("verdict", "s", "store"), ("dwell", "p", "pause"),
        ("paused", "p", "go_on"),
    ],
)  # fmt: skip
def test_a_key_means_what_it_means_on_the_screen(stage: StageName, typed: str, verb: str) -> None:
    assert command_of(typed, CalibrationView(stage=stage)) == OperatorCommand(verb=verb)


def test_no_word_is_broken_and_what_fits_stays_as_it_is() -> None:
    text = f"{KEYS_HELP}\n  bias x    12.5 ug\n\nend"
    lines = between_words(text, 80).split("\n")
    assert max(map(len, lines)) <= 80
    assert " ".join(lines).split() == text.split()
    assert lines[-3:] == ["  bias x    12.5 ug", "", "end"]
    assert between_words("/a/" + 90 * "b", 80) == "/a/" + 90 * "b"


def test_the_end_says_what_can_be_typed() -> None:
    said = list[str]()
    screen = PlainScreen(said.append, rings=False, asks=True)
    screen.show(VERDICT)
    assert said[-1].startswith("s store the calibration, d the diagnosis, o the report")
    screen.show(VERDICT.model_copy(update={"stage": "stored"}))
    assert said[-1] == "d the diagnosis, o the report, q leave"


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


def test_a_resumed_campaign_is_tried_at_another_port() -> None:
    first = OperatorCommand(verb="resume", folder="/c")
    assert command_of("can0", REFUSED, first) == OperatorCommand(verb="resume", folder="/c", url="can0")


def test_diagnosis_and_report_are_shown_at_the_end_only() -> None:
    assert (shown_at_end("d", VERDICT), shown_at_end("o\n", VERDICT)) == ("all of it", "/r.html")
    assert shown_at_end("d", CalibrationView(stage="dwell")) == ""
