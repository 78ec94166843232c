"""Whole programs on a simulated IMU behind an slcan adapter."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from mcap.reader import make_reader

from drivers.address_parsing import parse_device_url
from drivers.addresses import with_absolute_paths
from drivers.can.can_format import OWN_DBC
from drivers.framing import seen_instead
from drivers.ports import open_port, wire_of
from drivers.simulated.server import SimulatedDevice
from drivers.simulated.truth import Truth
from drivers.wire import WireFormat
from station import cli
from station.stream.recorder.sample_stream import check_raw_bytes
from tests.patience import paced

SPEED, PERIOD_S = 200.0, 0.1  # as many frames/s as 2000 samples/s give


@pytest.fixture
def device() -> Iterator[SimulatedDevice]:
    truth = replace(Truth.example(5), sample_period_s=PERIOD_S)
    with SimulatedDevice(truth, 5, speed=paced(SPEED), transport="slcan") as served:
        yield served


def wire(device: SimulatedDevice) -> WireFormat:
    found = wire_of(parse_device_url(device.url))
    assert found is not None
    return found


def test_a_recording_over_can_keeps_its_dbc_and_replays(
    device: SimulatedDevice, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.run(["record", device.url, "--seconds", "20", "--out", str(tmp_path / "r")]) == 0
    reported = capsys.readouterr().out
    assert "samples of fog-counts" in reported
    assert "0 frames lost" in reported
    path = tmp_path / "r" / "recording.mcap"
    assert check_raw_bytes(path, wire(device)) >= 200
    session = next((tmp_path / "r").glob("session_*.mcap"))
    with session.open("rb") as file:
        [about] = [each for each in make_reader(file).iter_metadata() if each.name == "station.session"]
    assert "BO_ 416 FOG_GYRO_X" in about.metadata["dbc"]
    assert "can-map/1" in about.metadata["map"]


def test_a_device_that_is_not_in_step_with_its_declared_rate_is_warned_of(
    device: SimulatedDevice, capsys: pytest.CaptureFixture[str]
) -> None:
    """A look on a busy machine may see too little of either: the next is longer."""

    def looks_at(url: str) -> Iterator[str]:
        for seconds in (0.5, 1.0, 2.0, 5.0, 20.0, 60.0):
            assert cli.run(["devices", "--url", url, "--seconds", f"{seconds:g}"]) == 0
            yield capsys.readouterr().out

    # it goes 200 times as fast as it says
    assert any("fog-counts" in reported and "warning" in reported for reported in looks_at(device.url))
    with SimulatedDevice(Truth.example(5), 5) as other:
        assert any("SIM-5" in reported and "warning" not in reported for reported in looks_at(other.url))


def test_what_comes_instead_of_samples_is_reported(device: SimulatedDevice, tmp_path: Path) -> None:
    """Another device's frames by our DBC, and two devices at once."""
    (tmp_path / "other.dbc").write_text(Path(OWN_DBC).read_text().replace("BO_ 4", "BO_ 5"))
    port = open_port(device.url)
    data = b"".join(port.read(65536) for _ in range(20))
    port.close()
    other = wire_of(parse_device_url(f"{device.url}&dbc={tmp_path / 'other.dbc'}"))
    assert other is not None
    foreign = seen_instead(other, data)
    records = [data[at : at + 32] for at in range(0, len(data) - 31, 32)]
    half = len(records) // 2
    both = b"".join(each for pair in zip(records, records[half:], strict=False) for each in pair)
    twofold = seen_instead(wire(device), both)
    assert foreign and twofold and foreign != twofold  # noqa: PT018
    assert seen_instead(wire(device), data) == ""


def test_a_wrong_mapping_is_exit_3_also_from_the_reader(
    device: SimulatedDevice, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "m.toml").write_text('format = "can-map/2"')
    url = f"{device.url}&map={tmp_path / 'm.toml'}"
    for command in (["devices", "--url", url], ["record", url, "--out", str(tmp_path / "r")]):
        assert cli.run(command) == 3
        assert "can-map/1" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("given", "kept"),
    [
        ("can://slcan/dev/ttyACM0?dbc=my.dbc&bitrate=1000000&map=a%20b/m.toml",
         "can://slcan/dev/ttyACM0?dbc={here}/my.dbc&bitrate=1000000&map={here}/a%20b/m.toml"),
        ("can://socketcan/can0?dbc=/lab/my.dbc", "can://socketcan/can0?dbc=/lab/my.dbc"),
        ("mavlink:udpin:0.0.0.0:14550?key=secret", "mavlink:udpin:0.0.0.0:14550?key={here}/secret"),
        ("replay:run.mcap?format=can", "replay:{here}/run.mcap?format=can"),
        ("serial:///dev/ttyUSB0?baud=115200&format=ch70", "serial:///dev/ttyUSB0?baud=115200&format=ch70"),
        ("", ""),
    ],
)  # fmt: skip
def test_only_the_files_of_an_address_become_whole_paths(
    given: str, kept: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert with_absolute_paths(given) == kept.format(here=tmp_path)
