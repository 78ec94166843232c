"""A wheel's signal of a DBC: frames made by cantools, read by us; what is no speed is refused."""

from pathlib import Path

import cantools.database
import pytest

from drivers.address_parsing import parse_device_url
from drivers.can.frame_record import REMOTE, pack
from drivers.can.wheel_signal import WheelDecoder, wheel_signal
from drivers.errors import BadCanFile, BadDeviceUrl
from drivers.simulated.companions.wheel_on_can import DBC, SIGNAL

FOREIGN = """VERSION ""
NS_ :
BS_:
BU_: A
BO_ 2566844670 CCVS: 8 A
 SG_ WheelBasedSpeed : 15|16@0+ (0.00390625,0) [0|250.996] "km/h" A
 SG_ Ratio : 32|8@1+ (0.4,0) [0|100] "rpm" A
 SG_ Bare : 40|8@1+ (0.1,0) [0|25] "" A
"""


@pytest.fixture
def foreign(tmp_path: Path) -> str:
    (tmp_path / "j.dbc").write_text(FOREIGN)
    return str(tmp_path / "j.dbc")


def test_frames_that_cantools_made_are_read_in_m_s(foreign: str) -> None:
    """Motorola byte order, a 29-bit identifier, 1/256 km/h: J1939's CCVS."""
    message = cantools.database.load_string(FOREIGN).get_message_by_name("CCVS")
    speeds = [0.0, 13.5, 249.0]
    frames = [message.encode({"WheelBasedSpeed": v, "Ratio": 40.0, "Bare": 1.0}) for v in speeds]
    records = b"".join(pack(message.frame_id | 0x80000000, 1000 + 20 * i, frame) for i, frame in enumerate(frames))
    decoder = WheelDecoder(wheel_signal(foreign, "CCVS.WheelBasedSpeed"))
    received = decoder.feed(records[:50], 5000) + decoder.feed(records[50:], 6000)
    assert [each.speed for each in received] == pytest.approx([v / 3.6 for v in speeds], abs=1e-3)
    assert [each.host_ns for each in received] == [5000, 5980, 6000]
    assert [each.came_ns for each in received] == [5000, 6000, 6000]  # nobody had the second before
    mph = WheelDecoder(wheel_signal(foreign, "CCVS.WheelBasedSpeed", "mph")).feed(records, 1)
    assert [each.speed for each in mph] == pytest.approx([v * 0.44704 for v in speeds], abs=1e-3)


def test_what_is_no_speed_is_counted_and_never_reported() -> None:
    signal = wheel_signal(DBC, SIGNAL)
    good = signal.frame(12.34, 0)
    assert good == pack(288, 0, (4442).to_bytes(2, "little") + bytes(6))
    damaged = bytearray(good)
    damaged[20] ^= 1
    unknown = pack(288, 0, b"\xff\xff" + bytes(6))
    other, short, remote = pack(289, 0, b"\1\2" + bytes(6)), pack(288, 0, b"\1"), pack(288 | REMOTE, 0, b"")
    decoder = WheelDecoder(signal)
    stream = b"noise" + good + bytes(damaged) + unknown + other + short + remote + good + good[:10]
    assert [round(each.speed, 2) for each in decoder.feed(stream, 0)] == [12.34, 12.34]
    assert (decoder.frames, decoder.refused, decoder.bad) == (3, 1, 1)
    assert len(decoder.feed(good[10:], 0)) == 1


@pytest.mark.parametrize(
    ("octets", "is_reported"),
    [
        ("fb00", True),  # 250.996 km/h, the most that the DBC states
        ("fb80", False),  # beyond it
        ("fe00", False),  # error indicator
        ("ffff", False),  # not available: 71.1 m/s if it were a speed
    ],
)
@pytest.mark.parametrize("stated", ["[0|251]", "[0|0]"])
def test_j1939s_marks_for_no_value_are_no_speed(
    tmp_path: Path, octets: str, is_reported: bool, stated: str
) -> None:
    (tmp_path / "j.dbc").write_text(FOREIGN.replace("[0|250.996]", stated))
    signal = wheel_signal(str(tmp_path / "j.dbc"), "CCVS.WheelBasedSpeed")
    decoder = WheelDecoder(signal)
    frame = pack(signal.identifier, 0, b"\0" + bytes.fromhex(octets) + bytes(5))
    is_beyond = octets == "fb80" and stated == "[0|0]"
    assert len(decoder.feed(frame, 0)) == (is_reported or is_beyond)


@pytest.mark.parametrize(
    ("name", "unit", "reported"),
    [
        ("CCVS.Ratio", "", "found CCVS.Ratio in 'rpm'; expected a unit of speed"),
        ("CCVS.Bare", "", "found CCVS.Bare without a unit"),
        ("CCVS.Bare", "parsec", "found CCVS.Bare in 'parsec'"),
        ("CCVS.Speed", "", "no signal 'Speed' in CCVS; expected one of WheelBasedSpeed, Ratio, Bare"),
        ("ESP.Speed", "", "no message 'ESP'; expected one of CCVS"),
        ("CCVS", "", "a name MESSAGE.SIGNAL"),
    ],
)
def test_a_wrong_signal_is_refused_in_one_line(foreign: str, name: str, unit: str, reported: str) -> None:
    with pytest.raises(BadCanFile) as refused:
        wheel_signal(foreign, name, unit)
    assert reported in str(refused.value)
    assert "\n" not in str(refused.value)
    assert wheel_signal(foreign, "CCVS.Bare", "m/s").factor == 1.0


def test_its_address_is_that_of_a_bus_with_a_signal() -> None:
    address = parse_device_url("wheel:can://slcan/dev/ttyACM0?bitrate=500000&dbc=a.dbc&signal=M.S")
    assert (address.bus.interface, address.bus.channel, address.bus.dbc) == ("slcan", "/dev/ttyACM0", "a.dbc")
    assert (address.signal, address.bus.options) == ("M.S", (("bitrate", "500000"),))
    for wrong in ("wheel:can://socketcan/can0", "wheel:serial:///dev/ttyUSB0", "wheel:can://socketcan/can0?dbc=a"):
        with pytest.raises(BadDeviceUrl):
            parse_device_url(wrong)
