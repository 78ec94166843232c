"""J1939: a frame is known by its PGN, from one source address only."""

from pathlib import Path

import numpy as np
import pytest

from drivers.can.can_format import can_format
from drivers.can.frame_record import ALL_BITS, pack, pgn_mask, pgn_of
from drivers.can.wheel_signal import WheelDecoder, wheel_signal
from drivers.errors import BadCanFile
from drivers.framing import Decoder
from procedures.errors import ErrorCode

# Angular rate (ARI, PGN 61482) and acceleration (ACCS, PGN 61485) as SAE J1939-71 defines them: 1/128 deg/s from
# -250 deg/s, 0.01 m/s2 from -320 m/s2
ARI, ACCS = 0x0CF02A, 0x0CF02D
DBC = """VERSION ""
NS_ :
BS_:
BU_: IMU
BO_ {ari} ARI: 8 IMU
 SG_ Y : 0|16@1+ (0.0078125,-250) [-250|250.99] "deg/s" IMU
 SG_ X : 16|16@1+ (0.0078125,-250) [-250|250.99] "deg/s" IMU
 SG_ Z : 32|16@1+ (0.0078125,-250) [-250|250.99] "deg/s" IMU
BO_ {accs} ACCS: 8 IMU
 SG_ Y : 0|16@1+ (0.01,-320) [-320|322.55] "m/s2" IMU
 SG_ X : 16|16@1+ (0.01,-320) [-320|322.55] "m/s2" IMU
 SG_ Z : 32|16@1+ (0.01,-320) [-320|322.55] "m/s2" IMU
"""
MAP = """format = "can-map/1"
output = "rate"
sample_period_s = 0.01
gyro = ["ARI.X", "ARI.Y", "ARI.Z"]
accel = ["ACCS.X", "ACCS.Y", "ACCS.Z"]
first = "ARI"
"""
WIDE = 1 << 31


def files(folder: Path, source: int = 0xFE, more_map: str = "", more_dbc: str = "") -> tuple[str, str]:
    dbc = DBC.format(ari=WIDE | ARI << 8 | source, accs=WIDE | ACCS << 8 | source) + more_dbc
    (folder / "imu.dbc").write_text(dbc)
    (folder / "imu.toml").write_text(MAP + more_map)
    return str(folder / "imu.dbc"), str(folder / "imu.toml")


def frames(n: int, source: int, priority: int = 3, raw_z: int = 32000 + 128, begin_ns: int = 10**9) -> list[bytes]:
    """Return n samples of 1 deg/s about z and 9.81 m/s2 along z."""
    rest = np.array([32000, 32000], "<u2").tobytes()
    found = list[bytes]()
    for i in range(n):
        rate = rest + np.array([raw_z, 0xFFFF], "<u2").tobytes()
        force = rest + np.array([32981, 0xFFFF], "<u2").tobytes()
        at = begin_ns + i * 10_000_000
        found.append(pack(WIDE | priority << 26 | (ARI & 0x3FFFF) << 8 | source, at, rate))
        found.append(pack(WIDE | priority << 26 | (ACCS & 0x3FFFF) << 8 | source, at + 10**6, force))
    return found


@pytest.mark.parametrize(
    ("identifier", "mask", "pgn"),
    [
        (WIDE | 0x0CF02AFE, 0xE3FFFF00, 61482),  # PDU2: PF F0
        (WIDE | 0x18EA2180, 0xE3FF0000, 0xEA00),  # PDU1, a request to 0x21: PGN 59904
        (WIDE | 0x19FE0180, 0xE3FFFF00, 0x1FE01),  # data page 1
        (0x100, ALL_BITS, None),
    ],
)  # fmt: skip
def test_the_bits_that_make_a_pgn(identifier: int, mask: int, pgn: int | None) -> None:
    assert pgn_mask(identifier) == mask
    if pgn is not None:
        assert pgn_of(identifier) == pgn


@pytest.mark.parametrize("source", [0x80, 0xFE, 0x00])
@pytest.mark.parametrize("priority", [3, 6])
def test_any_source_address_and_priority_is_read(source: int, priority: int, tmp_path: Path) -> None:
    block = Decoder(can_format(*files(tmp_path))).feed(b"".join(frames(50, source, priority)))
    assert len(block) == 50
    assert np.allclose(block.gyro, [0, 0, 1])
    assert np.allclose(block.accel, [0, 0, 9.81])


def test_a_destination_is_no_part_of_a_pdu1(tmp_path: Path) -> None:
    dbc, mapping = files(tmp_path)
    text = Path(dbc).read_text()
    for name, own in (("ARI", 0x0CEF1080), ("ACCS", 0x0CEE1080)):
        old = WIDE | {"ARI": ARI, "ACCS": ACCS}[name] << 8 | 0xFE
        text = text.replace(str(old), str(WIDE | own))
    Path(dbc).write_text(text)
    sent = [
        pack(WIDE | number << 16 | 0x2290, 10**9 + i * 10**7, bytes(8))
        for i in range(20)
        for number in (0x0CEF, 0x0CEE)
    ]  # to 0x22 from 0x90; the DBC says to 0x10 from 0x80
    assert len(Decoder(can_format(dbc, mapping)).feed(b"".join(sent))) == 20


def test_two_devices_are_refused_by_their_addresses(tmp_path: Path) -> None:
    both = b"".join(each for pair in zip(frames(20, 0x80), frames(20, 0x81), strict=True) for each in pair)
    with pytest.raises(BadCanFile) as error:
        Decoder(can_format(*files(tmp_path))).feed(both)
    assert error.value.code is ErrorCode.CAN_FILE
    assert all(each in error.value.found for each in ("0x80", "0x81", "61482"))
    assert all(f"source_address = {each}" in error.value.expected for each in ("0x80",))


def test_another_device_after_the_first_is_refused_too(tmp_path: Path) -> None:
    decoder = Decoder(can_format(*files(tmp_path)))
    assert len(decoder.feed(b"".join(frames(20, 0x80)))) == 20
    with pytest.raises(BadCanFile):
        decoder.feed(b"".join(frames(20, 0x81, begin_ns=10**11)))


@pytest.mark.parametrize("wanted", [0x80, 0x81])
def test_the_address_asked_for_is_read_alone(wanted: int, tmp_path: Path) -> None:
    one, other = frames(20, 0x80), frames(20, 0x81, raw_z=32000 + 256)
    both = b"".join(each for pair in zip(one, other, strict=True) for each in pair)
    decoder = Decoder(can_format(*files(tmp_path, more_map=f"source_address = {wanted:#x}\n")))
    block = decoder.feed(both)
    assert len(block) == 20
    assert np.allclose(block.gyro[:, 2], 1 if wanted == 0x80 else 2)
    assert decoder.counters.foreign == 40


def test_identifiers_as_in_the_dbc_where_the_mapping_says_so(tmp_path: Path) -> None:
    wire = can_format(*files(tmp_path, 0x80, 'source_address = "dbc"\n'))
    assert len(Decoder(wire).feed(b"".join(frames(20, 0x80)))) == 20
    decoder = Decoder(wire)
    assert len(decoder.feed(b"".join(frames(20, 0x81)))) == 0
    assert decoder.counters.foreign == 40


@pytest.mark.parametrize("source", ["256", "-1", "true", '"FE"', "254", "1.5"])
def test_an_address_that_no_device_has_is_refused(source: str, tmp_path: Path) -> None:
    with pytest.raises(BadCanFile, match="source_address"):
        can_format(*files(tmp_path, more_map=f"source_address = {source}\n"))


@pytest.mark.parametrize("raw", [0xFE00, 0xFFFF])
def test_what_j1939_calls_an_error_or_not_available_is_no_healthy_sample(raw: int, tmp_path: Path) -> None:
    block = Decoder(can_format(*files(tmp_path))).feed(b"".join(frames(20, 0x80, raw_z=raw)))
    assert not block.healthy.any()


def test_a_wheel_of_a_dbc_that_names_no_sender_is_any_ones(tmp_path: Path) -> None:
    """Cruise control/vehicle speed (CCVS, PGN 65265): 1/256 km/h from byte 2 on."""
    dbc = tmp_path / "truck.dbc"
    speed = ' SG_ Speed : 8|16@1+ (0.00390625,0) [0|250.996] "km/h" IMU\n'
    dbc.write_text(f'VERSION ""\nNS_ :\nBS_:\nBU_: IMU\nBO_ {WIDE | 0x18FEF1FE} CCVS: 8 IMU\n{speed}')
    data = b"\xff" + (36 * 256).to_bytes(2, "little") + b"\xff" * 5
    decoder = WheelDecoder(wheel_signal(str(dbc), "CCVS.Speed"))
    (reading,) = decoder.feed(pack(WIDE | 0x18FEF100, 10**9, data), 10**9)
    assert reading.speed == pytest.approx(10.0)
    with pytest.raises(BadCanFile, match="0x11"):
        decoder.feed(pack(WIDE | 0x18FEF111, 10**9, data), 10**9)
