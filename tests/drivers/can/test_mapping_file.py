"""What a mapping file makes of a DBC, key by key, and where each key's limits are."""

from pathlib import Path
from typing import Any

import pytest

from drivers.can.mapping_file import CanMap, load_map
from drivers.errors import BadCanFile

DBC = """VERSION ""
NS_ :
BS_:
BU_: IMU
BO_ 256 RATES: 8 IMU
 SG_ X : 0|16@1- (1,0) [0|0] "" IMU
 SG_ Y : 16|16@1- (1,0) [0|0] "" IMU
 SG_ COUNT : 32|8@1+ (1,0) [0|0] "" IMU
 SG_ FLAGS : 40|8@1+ (1,0) [0|0] "" IMU
 SG_ CRC : 56|8@1+ (1,0) [0|0] "" IMU
BO_ 2147484160 FORCES: 7 IMU
 SG_ Z : 0|16@1- (1,0) [0|0] "" IMU
 SG_ COUNT : 32|8@1+ (1,0) [0|0] "" IMU
 SG_ FLAGS : 40|8@1+ (1,0) [0|0] "" IMU
 SG_ CRC : 48|8@1+ (1,0) [0|0] "" IMU
BO_ 258 CLOCK: 4 IMU
 SG_ NOW : 0|32@1+ (1,0) [0|0] "" IMU
BO_ 259 WARMTH: 2 IMU
 SG_ KELVIN : 0|16@1- (0.1,0) [0|0] "" IMU
BO_ 260 WIDE: 8 IMU
 SG_ UNSIGNED : 0|64@1+ (1,0) [0|0] "" IMU
BO_ 261 DEEP: 8 IMU
 SG_ SIGNED : 0|64@1- (1,0) [0|0] "" IMU
BO_ 262 SMALL: 8 IMU
 SG_ UNSIGNED : 0|63@1+ (1,0) [0|0] "" IMU
BO_ 263 FLOATING: 8 IMU
 SG_ REAL : 0|32@1- (1,0) [0|0] "" IMU
BO_ 264 ODD: 8 IMU
 SG_ SKEW : 20|8@1+ (1,0) [0|0] "" IMU
 SG_ SEVEN : 32|7@1+ (1,0) [0|0] "" IMU
SIG_VALTYPE_ 263 REAL : 1;
"""
X, Y, Z = "RATES.X", "RATES.Y", "FORCES.Z"
PLAIN: dict[str, Any] = {
    "format": "can-map/1", "output": "increments", "sample_period_s": 0.01, "gyro": [X, Y, Z],
    "accel": [Z, Y, X], "first": "FORCES",
}  # fmt: skip


KEYS = (
    "accel, check, check_kind, counter, fault_bits, first, format, good_bits, gyro, max_step, name, output, "
    "padded, sample_period_s, source_address, status, temperature, time, time_unit_s"
)


def toml(value: Any) -> str:
    match value:
        case bool():
            return str(value).lower()
        case str():
            return f'"{value}"'
        case list():
            return f"[{', '.join(map(toml, value))}]"
        case _:
            return repr(value)


def mapped(folder: Path, period: float | None = None, **changed: Any) -> CanMap:
    """Return the map of the plain keys with some changed; None leaves one out."""
    keys = {key: value for key, value in (PLAIN | changed).items() if value is not None}
    (folder / "imu.dbc").write_text(DBC)
    (folder / "my_imu.toml").write_text("".join(f"{key} = {toml(value)}\n" for key, value in keys.items()))
    return load_map(str(folder / "imu.dbc"), str(folder / "my_imu.toml"), period)


def refused(folder: Path, **changed: Any) -> BadCanFile:
    with pytest.raises(BadCanFile) as error:
        mapped(folder, **changed)
    return error.value


def test_a_short_mapping_is_filled_up(tmp_path: Path) -> None:
    found = mapped(tmp_path)
    assert (found.name, found.title) == ("my_imu", "imu.dbc as my_imu.toml reads it")
    assert (found.output, found.period, found.first, found.counts_every_frame) == ("increments", 0.01, 1, False)
    assert (found.fault_bits, found.good_bits, found.check_kind, found.time_unit) == (0, 0, "", 1.0)
    assert (found.is_padded, found.max_step, found.needed, found.counter) == (False, None, 2, None)


def test_what_is_stated_stands(tmp_path: Path) -> None:
    found = mapped(
        tmp_path, name="mine", output="cumulative", fault_bits=6, good_bits=9, check="RATES.CRC",
        check_kind="xor8", time="CLOCK.NOW", time_unit_s=1e-3, padded=True, max_step=500,
    )  # fmt: skip
    assert (found.name, found.output, found.fault_bits, found.good_bits) == ("mine", "cumulative", 6, 9)
    assert (found.check_kind, found.time_unit, found.is_padded, found.max_step) == ("xor8", 1e-3, True, 500)


@pytest.fixture
def full(tmp_path: Path) -> CanMap:
    return mapped(
        tmp_path, status="FORCES.FLAGS", counter="RATES.COUNT", time="CLOCK.NOW", time_unit_s=1e-6,
        temperature="WARMTH.KELVIN", first="CLOCK",
    )  # fmt: skip


def test_a_frame_has_the_channels_and_signals_that_are_in_it(full: CanMap) -> None:
    rates, forces, clock, warmth = full.slots
    assert [(i, field.start) for i, field in rates.channels] == [(0, 0), (1, 16), (4, 16), (5, 0)]
    assert [(i, field.start) for i, field in forces.channels] == [(2, 0), (3, 0)]
    assert clock.channels == warmth.channels == ()
    assert rates.counter is not None
    assert rates.counter.start == 32
    assert full.counter is rates.counter
    assert forces.status is not None
    assert forces.status.start == 40
    assert clock.time is not None
    assert clock.time.bits == 32
    assert warmth.temperature is not None
    assert warmth.temperature.scale == 0.1
    assert (rates.status, rates.time, rates.check, forces.counter) == (None, None, None, None)
    assert (forces.temperature, clock.temperature, warmth.status) == (None, None, None)


def test_a_bare_name_stands_in_every_frame(tmp_path: Path) -> None:
    found = mapped(tmp_path, counter="COUNT", status="FLAGS", check="CRC", check_kind="crc8-j1850", first=None)
    assert (found.counts_every_frame, found.first) == (True, 0)
    for slot in found.slots:
        assert slot.counter is not None
        assert slot.status is not None
        assert slot.check is not None
        assert (slot.counter.start, slot.status.start) == (32, 40)
    assert [slot.check.start for slot in found.slots if slot.check] == [56, 48]


@pytest.mark.parametrize("names", ["RATES.X", [X, Y], [X, Y, Z, X], [X, Y, 3]])
@pytest.mark.parametrize("key", ["gyro", "accel"])
def test_a_triad_is_of_three_names(key: str, names: Any, tmp_path: Path) -> None:
    error = refused(tmp_path, **{key: names})
    assert error.found == f"{key} = {names!r}"
    assert error.expected == "three names MESSAGE.SIGNAL, those of x, y, z"


def test_a_device_may_lack_a_triad_but_not_both(tmp_path: Path) -> None:
    assert mapped(tmp_path, accel=None, first="RATES").channels == {"gx", "gy", "gz"}
    assert mapped(tmp_path, gyro=None).channels == {"ax", "ay", "az"}
    assert refused(tmp_path, gyro=None, accel=None).found == "neither gyro nor accel"


@pytest.mark.parametrize(
    ("signal", "is_count"),
    [("WIDE.UNSIGNED", False), ("FLOATING.REAL", False), ("DEEP.SIGNED", True), ("SMALL.UNSIGNED", True)],
)
def test_a_count_is_a_whole_number_of_a_signed_64_bits(signal: str, is_count: bool, tmp_path: Path) -> None:
    assert mapped(tmp_path, output="rate", gyro=[X, Y, signal]).needed == 3
    for output in ("increments", "cumulative"):
        if is_count:
            assert mapped(tmp_path, output=output, gyro=[X, Y, signal]).needed == 3
            continue
        error = refused(tmp_path, output=output, gyro=[X, Y, signal])
        assert error.found == f"gyro {signal}, which is no whole number of up to 64 bits"


@pytest.mark.parametrize(
    ("changed", "found", "expected"),
    [
        ({"format": None}, "format = None", "'can-map/1'"),
        ({"output": "counts"}, "output = 'counts'", "one of increments, cumulative, rate"),
        ({"first": "CLOCK"}, "first = 'CLOCK' and no counter in every frame", "one of RATES, FORCES"),
        ({"first": None}, "first = '' and no counter in every frame", "one of RATES, FORCES"),
        ({"gyro": ["X", Y, Z]}, "'X'", "a name MESSAGE.SIGNAL"),
        ({"zebra": 1, "ant": 1}, "key 'ant'", KEYS),
        ({"check": "CRC"}, "check_kind = ''", "one of crc8-autosar, crc8-autosar-id, crc8-j1850, xor8"),
    ],
)  # fmt: skip
def test_a_wrong_key_says_what_is_accepted(
    changed: dict[str, Any], found: str, expected: str, tmp_path: Path
) -> None:
    error = refused(tmp_path, **changed)
    assert (error.found, error.expected) == (found, expected)
