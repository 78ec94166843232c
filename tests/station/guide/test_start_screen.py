"""The set-up is remembered, what can be chosen is listed, and a look at any port or receiver says what to do."""

import re
import time
from collections.abc import Iterable
from dataclasses import replace
from datetime import date
from pathlib import Path

import pytest

from drivers.simulated.companions.gnss_server import SimulatedGnss
from drivers.simulated.device import ByteDevice
from drivers.simulated.faults import Fault
from drivers.simulated.server import SimulatedDevice
from drivers.simulated.truth import Truth
from fixtures_db.database import Database, open_db
from fixtures_db.fixtures import add_fixture
from fixtures_db.schema import CubeRow, SlabRow
from station.errors import CannotWrite
from station.files.campaign_setup import Setup
from station.guide.campaign.port_check import check_port, check_receiver
from station.guide.engine import CalibrationEngine
from station.guide.options import CalibrationOptions, load_setup, save_setup, setup_file
from station.guide.start_screen import start_view
from station.guide.view import CalibrationView, OperatorCommand
from tests.patience import HANG_S, paced
from tests.station.guide.recorded import begin


@pytest.fixture(autouse=True)
def config(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("STATION_CONFIG", str(tmp_path / "config"))
    return tmp_path / "config"


def test_the_set_up_is_remembered(config: Path) -> None:
    assert load_setup() == Setup()
    setup = Setup(url="serial:///dev/ttyUSB0", latitude_deg=48.1, operator="Curie", cube="CUBE-7", dwell_s=20.5)
    save_setup(setup)
    assert load_setup() == setup
    assert [path.name for path in config.iterdir()] == ["setup.json"]


@pytest.mark.parametrize("content", [b"", b"{", b"[]", b'{"url": 3}', b'{"urls": "x"}', b"\xff\xfe", b"null"])
def test_a_broken_set_up_is_the_default_one(config: Path, content: bytes) -> None:
    config.mkdir()
    setup_file().write_bytes(content)
    assert load_setup() == Setup()
    save_setup(Setup(operator="x"))
    assert load_setup().operator == "x"


def test_a_place_that_cannot_be_written_is_reported(config: Path) -> None:
    config.write_text("a file, not a folder")
    assert load_setup() == Setup()
    with pytest.raises(CannotWrite):
        save_setup(Setup())


def test_cubes_and_slabs_stand_there_with_their_certificates(db: Database, tmp_path: Path) -> None:
    with db.write() as session:
        add_fixture(session, CubeRow(id="OLD", side_mm=200.0, due_date=date(2020, 2, 1)))
        add_fixture(session, CubeRow(id="NEW", side_mm=200.0, due_date=date(2100, 2, 1)))
        add_fixture(session, SlabRow(id="SLAB", due_date=date(2020, 2, 1)))
    begin(tmp_path / "c", db)
    start = start_view(db, Setup(operator="x"))
    assert {cube.key: (cube.note, cube.warns) for cube in start.cubes} == {
        "OLD": ("certificate expired on 2020-02-01", True),
        "NEW": ("certificate due 2100-02-01", False),
        "P1": ("no certificate date", True),
    }
    assert [(slab.key, slab.note) for slab in start.slabs] == [("SLAB", "certificate expired on 2020-02-01")]
    assert start.cubes[0].title == "NEW 200 mm"
    assert (start.setup.operator, len(start.unfinished)) == ("x", 1)


def replayed(folder: Path, faults: Iterable[Fault] = (), truth: Truth | None = None) -> str:
    """Return the address of 500 samples of a simulated unit, to be read as fast as they can be."""
    device, path = ByteDevice(truth or Truth.example(5), 5, "counts", faults), folder / "bytes"
    while device.samples < 500:
        with path.open("ab") as stream:
            stream.write(b"".join(part for part in device.chunk() if isinstance(part, bytes)))
    return f"replay:{path}"


def test_a_good_port_is_reported_as_good(tmp_path: Path) -> None:
    check = check_port(replayed(tmp_path), 60.0)
    assert check.is_good, check.text
    assert (check.format, check.serial, check.bad_frames) == ("counts", "SIM-5", 0)
    assert check.rate_hz == pytest.approx(50.0)
    assert check.frames >= 500
    assert "counts rms in 0.1 s" in check.noise


def test_a_dead_channel_is_named(tmp_path: Path) -> None:
    unit = Truth.example(5)
    dead = replace(unit, gyro_k=unit.gyro_k * [1.0, 0.0, 1.0])
    check = check_port(replayed(tmp_path, truth=dead), 60.0)
    assert not check.is_good
    assert "gyroscope y a constant 0 for 10 s: dead or not there" in check.text


def test_a_bad_line_is_named_with_what_to_do(tmp_path: Path) -> None:
    check = check_port(replayed(tmp_path, [Fault("bad_crc", 0.2 * n) for n in range(1, 50)]), 60.0)
    assert not check.is_good
    assert check.bad_frames == 49
    assert "frames are damaged, expected less than 1%; check cable" in check.text
    assert "frames are missing at" in check.text


@pytest.mark.parametrize(
    ("url", "reported"),
    [
        ("serial:///dev/ttyNONE", "no such port"),
        ("nonsense", "no address"),
        ("", "no address"),
        ("tcp://127.0.0.1:1", "check address, port"),
        ("replay:/no/such/file", "No such file"),
    ],
)
def test_what_cannot_be_looked_at_is_words_not_an_error(url: str, reported: str) -> None:
    check = check_port(url, 0.1)
    assert (check.is_good, check.url) == (False, url)
    assert reported in check.text


TRUTH = replace(Truth.example(5), latitude_deg=48.1, longitude_deg=11.5, height_m=520.0)
SPEED = 60.0


def test_a_receiver_says_where_it_stands_with_sigma() -> None:
    with SimulatedGnss(TRUTH, speed=10.0) as gnss:
        check = check_receiver(gnss.url)
    assert check.is_good
    latitude, longitude, height, u, *_ = map(float, re.findall(r"-?\d+\.\d+", check.text))
    assert latitude == pytest.approx(48.1, abs=1e-4)
    assert longitude == pytest.approx(11.5, abs=1e-4)
    assert height == pytest.approx(520.0, abs=12.0)
    assert 0.1 < u < 10.0


def test_the_campaign_waits_for_looks_and_says_the_site_that_it_took(tmp_path: Path) -> None:
    shown: list[CalibrationView] = []
    with (
        SimulatedDevice(TRUTH, 5, speed=paced(SPEED)) as device,
        SimulatedGnss(device.truth, imu=device) as gnss,
        open_db(tmp_path / "s.db") as database,
    ):
        engine = CalibrationEngine(
            database, CalibrationOptions(tmp_path, asks=False, warms_up=False), shown.append
        )
        try:
            engine.execute(OperatorCommand(verb="listen", url=gnss.url))
            assert engine.view.start is not None
            assert engine.view.start.is_listening
            engine.execute(OperatorCommand(verb="check", url=device.url))
            setup = Setup(url=device.url, gnss=gnss.url, longitude_deg=12.5, folder=str(tmp_path / "c"))
            engine.execute(OperatorCommand(verb="begin", setup=setup))  # both ports are still being looked at
            until = time.monotonic() + HANG_S
            while not engine.view.gates:
                assert time.monotonic() < until, (engine.view.stage, engine.view.start)
                engine.round()
            [reported] = [event.text for event in engine.view.events if "GNSS" in event.text]
        finally:
            engine.close()
    assert "for 20 positions of the receiver" in shown[0].hint
    assert reported.startswith("site from GNSS: 48.")
    assert re.search(r" u \d+\.\d m", reported)
    assert reported.endswith("longitude_deg 12.5 is stated, GNSS gives 11.5")
