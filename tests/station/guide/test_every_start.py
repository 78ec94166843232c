"""What hinders a campaign's start ends a program that nobody sits at, or leaves a form where a person can act."""

import os
import pty
import socket
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path

import pytest

from drivers.errors import BadDeviceUrl, LinkSilent, PortBusy, PortNotFound, WrongFormat
from drivers.ports import open_port
from drivers.simulated.faults import Fault
from drivers.simulated.server import SimulatedDevice
from drivers.simulated.truth import Truth
from fixtures_db.database import Database
from station.errors import CannotWrite, exit_code
from station.files.campaign_setup import Setup
from station.guide.engine import REFUSALS, CalibrationEngine
from station.guide.headless import run_headless
from station.guide.options import CalibrationOptions, EngineOptions
from station.guide.view import CalibrationView, OperatorCommand
from tests.empty_database import empty_db
from tests.patience import HANG_S


@dataclass(frozen=True)
class Hindrance:
    """A set-up that cannot begin, why not, and what else must be in its line."""

    setup: Setup
    error: type[Exception]
    reported: str = ""


Made = Iterator[Hindrance]
HINDRANCES: dict[str, Callable[[Path], Made]] = {}


def hindrance(make: Callable[[Path], Made]) -> Callable[[Path], Made]:
    HINDRANCES[make.__name__] = make
    return make


def at(url: str, error: type[Exception], reported: str = "", **more: object) -> Hindrance:
    return Hindrance(Setup(url=url, latitude_deg=31.0, **more), error, reported)


@hindrance
def no_such_port(folder: Path) -> Made:
    yield at("/dev/ttyNONE", PortNotFound, "/dev/ttyNONE")


@hindrance
def a_port_that_another_program_holds(folder: Path) -> Made:
    with SimulatedDevice(Truth.example(5), 5) as device:
        port = open_port(device.url)
        yield at(device.url, PortBusy)
        port.close()


@hindrance
def a_silent_port(folder: Path) -> Made:
    ours, theirs = pty.openpty()
    yield at(f"{os.ttyname(theirs)}?format=counts", LinkSilent)
    os.close(ours)
    os.close(theirs)


@hindrance
def a_wrong_format(folder: Path) -> Made:
    with SimulatedDevice(Truth.example(5), 5) as device:
        yield at(device.url.replace("counts", "stim300"), WrongFormat, "format=counts")


@hindrance
def bytes_of_no_format(folder: Path) -> Made:
    with SimulatedDevice(Truth.example(5), 5, faults=[Fault("noise", at_s=0.0, seconds=1e6)]) as device:
        yield at(device.url.partition("?")[0], WrongFormat)


@hindrance
def nobody_listens_on_tcp(folder: Path) -> Made:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        yield at(f"127.0.0.1:{taken.getsockname()[1]}", PortNotFound)


@hindrance
def a_port_of_windows(folder: Path) -> Made:
    yield at("COM3", BadDeviceUrl, "/dev/ttyUSB0")


@hindrance
def a_receiver_where_the_imu_should_be(folder: Path) -> Made:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        number = free.getsockname()[1]
    yield at(f"udp:127.0.0.1:{number}", BadDeviceUrl, "--gnss")


@hindrance
def a_folder_that_cannot_be_made(folder: Path) -> Made:
    (folder / "file").touch()
    with SimulatedDevice(Truth.example(5), 5) as device:
        yield at(device.url, CannotWrite, folder=str(folder / "file" / "c"))


@dataclass(frozen=True)
class Begun:
    """What became of a start: the form that it stayed at, whether a folder was made, how it ended without one."""

    hindrance: Hindrance
    view: CalibrationView
    made_folder: bool
    ended: BaseException


def begun(name: str, folder: Path, database: Database) -> Begun:
    with contextmanager(HINDRANCES[name])(folder) as made:
        where = {} if made.setup.folder else {"folder": str(folder / "c")}
        setup = made.setup.model_copy(update=where)
        begin = OperatorCommand(verb="begin", setup=setup)
        engine = CalibrationEngine(database, CalibrationOptions(folder, asks=False), lambda view: None)
        engine.execute(begin)
        engine.close()
        made_folder = (folder / "c").exists()
        options = EngineOptions(root=folder, setup=setup, asks=False, warms_up=False, first=begin)
        with pytest.raises(REFUSALS) as refused:
            run_headless(options, database, lambda view: None, stores=False)
        return Begun(made, engine.view, made_folder, refused.value)


@pytest.fixture(scope="module")
def starts(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, Future[Begun]]]:
    """All of them at once: they wait for bytes that do not come."""
    folders = {name: tmp_path_factory.mktemp(name) for name in HINDRANCES}
    with ExitStack() as opened:
        databases = {name: opened.enter_context(empty_db(folders[name] / "s.db")) for name in folders}
        pool = opened.enter_context(ThreadPoolExecutor(len(folders)))
        yield {name: pool.submit(begun, name, folders[name], databases[name]) for name in folders}


@pytest.mark.parametrize("name", HINDRANCES)
def test_a_hindered_start_stays_at_a_form_and_ends_without_one_by_the_same_words(
    starts: dict[str, Future[Begun]], name: str
) -> None:
    found = starts[name].result(HANG_S)
    assert found.view.stage == "start"
    assert isinstance(found.ended, found.hindrance.error)
    assert found.view.start.refused_code == exit_code(found.ended)
    assert not found.made_folder
    assert found.hindrance.reported in str(found.ended)
    assert found.view.start.refused
