"""DBCs and mapping files: foreign ones decode to their golden values, wrong ones are refused by name and line."""

import ast
import csv
import re
from pathlib import Path

import numpy as np
import pytest

from drivers.can import frame_record
from drivers.can.can_format import OWN_DBC, OWN_MAP, can_format
from drivers.can.dbc_signals import field_of, identifier_of, load_dbc, words_of
from drivers.errors import BadCanFile
from drivers.framing import Decoder
from drivers.wire import WireFormat
from procedures.counts.sample_records import RateBlock
from station import cli
from tests.drivers.can.frames import DBC, needs_captures

SBG_MAP = """
format = "can-map/1"
output = "rate"
sample_period_s = 0.01
gyro = ["SBG_ECAN_MSG_IMU_GYRO.GYRO_X", "SBG_ECAN_MSG_IMU_GYRO.GYRO_Y", "SBG_ECAN_MSG_IMU_GYRO.GYRO_Z"]
accel = ["SBG_ECAN_MSG_IMU_ACCEL.ACCEL_X", "SBG_ECAN_MSG_IMU_ACCEL.ACCEL_Y", "SBG_ECAN_MSG_IMU_ACCEL.ACCEL_Z"]
first = "SBG_ECAN_MSG_IMU_INFO"
time = "SBG_ECAN_MSG_IMU_INFO.TIME_STAMP"
time_unit_s = 1e-6
status = "SBG_ECAN_MSG_IMU_INFO.STATUS"
good_bits = 0x7F
temperature = "SBG_ECAN_MSG_IMU_INFO.TEMPERATURE"
"""


def golden() -> list[dict[str, str]]:
    if not DBC.is_dir():
        return []
    with (DBC / "golden.csv").open(newline="") as file:
        return list(csv.DictReader(file))


@needs_captures
@pytest.mark.parametrize("row", golden(), ids=lambda row: row["message"])
def test_every_golden_payload_decodes_to_its_values(row: dict[str, str]) -> None:
    path = str(DBC / row["dbc"])
    message = load_dbc(path).get_message_by_name(row["message"])
    assert identifier_of(message) == int(row["id"], 16)
    payload = bytes.fromhex(row["data_hex"]).ljust(8, b"\0")
    words = words_of(np.frombuffer(payload, np.uint8).reshape(1, 8))
    for name, value in ast.literal_eval(row["decoded"]).items():
        assert field_of(path, message, name).value(words)[0] == float(value), name


@needs_captures
def test_a_foreign_dbc_keeps_its_degree_signs() -> None:
    units = {signal.unit for each in load_dbc(str(DBC / "sbgCan.dbc")).messages for signal in each.signals}
    assert "°C" in units
    assert not any("\ufffd" in (unit or "") for unit in units)


@needs_captures
def test_a_foreign_device_is_joined_by_the_order_of_its_frames(tmp_path: Path) -> None:
    (tmp_path / "sbg.toml").write_text(SBG_MAP)
    wire = can_format(str(DBC / "sbgCan.dbc"), str(tmp_path / "sbg.toml"))
    rows = {row["message"]: row for row in golden()}
    names = [f"SBG_ECAN_MSG_IMU_{part}" for part in ("INFO", "ACCEL", "GYRO")]
    records = [
        frame_record.pack(int(rows[name]["id"], 16), 10**9 + i, bytes.fromhex(rows[name]["data_hex"]))
        for i, name in enumerate(names)
    ]
    decoder = Decoder(wire)
    block = decoder.feed(b"".join(records))
    assert (wire.output, type(block)) == ("rate", RateBlock)
    np.testing.assert_allclose(block.gyro, [[-1.234, 0.567, 32.767]])  # rad/s, as the DBC says
    np.testing.assert_allclose(block.accel, [[9.81, -327.68, 0.01]])
    assert (block.device_time[0], block.temperature[0], block.status[0]) == (123.456789, 25.43, 32767)
    later = [records[0], records[2]]  # its accelerometer frame is lost
    assert len(decoder.feed(b"".join([*later, *records]))) == 0
    assert len(decoder.feed(records[0])) == 1
    assert decoder.counters.incomplete == 1


@needs_captures
def test_a_dbc_with_a_syntax_error_is_refused_with_its_line() -> None:
    with pytest.raises(BadCanFile, match="CM_") as refused:
        load_dbc(str(DBC / "hyundai_can_upstream_syntax_error.dbc"))
    assert refused.value.line == 1656
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("old", "new", "found"),
    [
        ('format = "can-map/1"', 'format = "can-map/2"', "format = 'can-map/2'"),
        ('counter = "COUNTER"', 'counter = "COUNTRE"', "no signal 'COUNTRE' in FOG_GYRO_X"),
        ('"FOG_GYRO_X.COUNT"', '"FOG_GYRO_W.COUNT"', "message 'FOG_GYRO_W'"),
        ('"FOG_GYRO_X.COUNT"', '"COUNT"', "'COUNT'"),
        ('counter = "COUNTER"', "", "first = '' and no counter in every frame"),
        ("crc8-autosar-id", "crc9", "check_kind = 'crc9'"),
        ('check = "CRC"', 'check = "COUNTER"', "check in FOG_GYRO_X of 16 bits"),
        ('output = "increments"', 'output = "counts"', "output = 'counts'"),
        ("sample_period_s = 0.002", "sample_period_s = 0", "sample_period_s = 0"),
        ("fault_bits = 0xFF", "fault_bitts = 1", "key 'fault_bitts'"),
        ("fault_bits = 0xFF", "fault_bits = -1", "fault_bits = -1"),
        ("gyro = [", "gyro = [1,", "three names"),
        ("format =", "format", "Expected '=' after a key"),
    ],
)
def test_a_wrong_mapping_is_refused_by_the_key(old: str, new: str, found: str, tmp_path: Path) -> None:
    text = Path(OWN_MAP).read_text()
    assert old in text
    (tmp_path / "map.toml").write_text(text.replace(old, new))
    with pytest.raises(BadCanFile) as refused:
        can_format(OWN_DBC, str(tmp_path / "map.toml"))
    assert found in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("name", ["dbc", "map"])
def test_a_missing_file_is_refused(name: str, tmp_path: Path) -> None:
    files = {"dbc": OWN_DBC, "map": OWN_MAP, name: str(tmp_path / "none")}
    with pytest.raises(BadCanFile, match=str(tmp_path / "none")):
        can_format(files["dbc"], files["map"])


FOREIGN = """VERSION ""
NS_ :
BS_:
BU_: IMU
BO_ 256 RATES: 8 IMU
 SG_ X : 0|32@1- (1,0) [0|0] "rad/s" IMU
 SG_ Y : 32|32@1- (1,0) [0|0] "rad/s" IMU
BO_ 257 MORE: 8 IMU
 SG_ Z : 0|32@1- (1,0) [0|0] "rad/s" IMU
 SG_ FX : 32|32@1- (1,0) [0|0] "g" IMU
BO_ 258 FORCES: 8 IMU
 SG_ FY : 7|32@0- (1,0) [0|0] "g" IMU
 SG_ FZ : 39|32@0- (1,0) [0|0] "g" IMU
BO_ 259 SWITCHED: 8 IMU
 SG_ WHICH M : 0|8@1+ (1,0) [0|0] "" IMU
 SG_ AXIS m0 : 8|32@1- (1,0) [0|0] "rad/s" IMU
BO_ 260 LONG: 64 IMU
 SG_ FAR : 400|32@1- (1,0) [0|0] "rad/s" IMU
SIG_VALTYPE_ 256 X : 1;
SIG_VALTYPE_ 256 Y : 1;
SIG_VALTYPE_ 257 Z : 1;
SIG_VALTYPE_ 257 FX : 1;
SIG_VALTYPE_ 258 FY : 1;
SIG_VALTYPE_ 258 FZ : 1;
"""
FLOATS = """
format = "can-map/1"
output = "rate"
sample_period_s = 0.01
gyro = ["RATES.X", "RATES.Y", "MORE.Z"]
accel = ["MORE.FX", "FORCES.FY", "FORCES.FZ"]
first = "RATES"
"""


def foreign(folder: Path, mapping: str) -> WireFormat:
    (folder / "imu.dbc").write_text(FOREIGN)
    (folder / "imu.toml").write_text(mapping)
    return can_format(str(folder / "imu.dbc"), str(folder / "imu.toml"))


def test_float_signals_are_rates_as_cantools_reads_them(tmp_path: Path) -> None:
    wire = foreign(tmp_path, FLOATS)
    database = load_dbc(str(tmp_path / "imu.dbc"))
    sent = {"RATES": {"X": 0.125, "Y": -1e-6}, "MORE": {"Z": 3.5, "FX": -0.25}, "FORCES": {"FY": 1e3, "FZ": -1.0}}
    ids = {"RATES": 256, "MORE": 257, "FORCES": 258}
    records = [frame_record.pack(ids[name], 10**9, database.encode_message(ids[name], sent[name])) for name in ids]
    block = Decoder(wire).feed(b"".join(records))
    assert isinstance(block, RateBlock)
    np.testing.assert_array_equal(block.gyro, np.array([[0.125, -1e-6, 3.5]], np.float32))
    np.testing.assert_array_equal(block.accel, [[-0.25, 1e3, -1.0]])


def test_frames_joined_by_their_order_are_of_one_sample_period(tmp_path: Path) -> None:
    """The first turn lost its last frame, the second its first two: what is left makes no sample of both."""
    decoder = Decoder(foreign(tmp_path, FLOATS))
    database = load_dbc(str(tmp_path / "imu.dbc"))
    signals = {256: ("X", "Y"), 257: ("Z", "FX"), 258: ("FY", "FZ")}  # one ms after another
    turns = [(256, 257), (258,), *4 * [(256, 257, 258)]]
    records = [
        frame_record.pack(
            frame,
            (10 * turn + frame - 256) * 10**6,
            database.encode_message(frame, dict.fromkeys(signals[frame], turn)),
        )
        for turn, frames in enumerate(turns)
        for frame in frames
    ]
    block = decoder.feed(b"".join(records))
    np.testing.assert_array_equal(np.hstack((block.gyro, block.accel)), np.tile(np.arange(2.0, 6)[:, None], 6))
    assert decoder.counters.late == 1


@pytest.mark.parametrize(
    ("old", "new", "reported"),
    [
        ("MORE.Z", "SWITCHED.AXIS", "SWITCHED.AXIS"),
        ("MORE.Z", "LONG.FAR", "LONG.FAR"),
        ('"rate"', '"increments"', "RATES.X"),
    ],
)
def test_what_cannot_be_read_is_refused_in_one_line(
    old: str, new: str, reported: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(BadCanFile, match=re.escape(reported)):
        foreign(tmp_path, FLOATS.replace(old, new))
    files = f"dbc={tmp_path / 'imu.dbc'}&map={tmp_path / 'imu.toml'}"
    assert cli.run(["devices", "--url", f"can://udp_multicast/239.74.163.2?{files}"]) == 3
    error = capsys.readouterr().err
    assert reported in error
    assert error.count("\n") == 1
