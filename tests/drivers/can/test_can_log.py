"""Logs of other programs as replays: the same samples whoever wrote them, and one refusal for what is unclear."""

from collections.abc import Callable
from pathlib import Path

import can
import numpy as np
import pytest
from can.io import ASCWriter, BLFWriter, CSVWriter, TRCWriter

from drivers.address_parsing import parse_device_url
from drivers.can.can_format import can_format
from drivers.errors import BadCanFile, ReplayEnded
from drivers.framing import Decoder
from drivers.ports import open_port
from procedures.counts.sample_records import SampleBlock

DBC = """VERSION ""
NS_ :
BS_:
BU_: IMU
BO_ 256 GYRO: 8 IMU
 SG_ GX : 7|16@0- (0.01,0) [0|0] "deg/s" IMU
 SG_ GY : 23|16@0- (0.01,0) [0|0] "deg/s" IMU
 SG_ GZ : 39|16@0- (0.01,0) [0|0] "deg/s" IMU
 SG_ CNT : 55|16@0+ (1,0) [0|65535] "" IMU
BO_ 257 ACC: 8 IMU
 SG_ AX : 7|16@0- (0.001,0) [0|0] "g" IMU
 SG_ AY : 23|16@0- (0.001,0) [0|0] "g" IMU
 SG_ AZ : 39|16@0- (0.001,0) [0|0] "g" IMU
 SG_ CNT : 55|16@0+ (1,0) [0|65535] "" IMU
"""
MAP = """format = "can-map/1"
output = "rate"
sample_period_s = 0.01
gyro = ["GYRO.GX", "GYRO.GY", "GYRO.GZ"]
accel = ["ACC.AX", "ACC.AY", "ACC.AZ"]
counter = "CNT"
"""
N, EPOCH = 100, 1767225600.0


def messages(channel: int | str = 0, rate: int = 1234) -> list[can.Message]:
    found = list[can.Message]()
    for i in range(N):
        for k, values in enumerate(((rate, -5, 65), (10, 20, 1000))):
            data = np.array([*values, i], ">i2").tobytes()
            stamp = EPOCH + 0.01 * i + 0.001 * k
            found.append(can.Message(stamp, 256 + k, is_extended_id=False, data=data, channel=channel, check=True))
    return found


def candump_l(path: Path, sent: list[can.Message]) -> None:
    path.write_text(
        "".join(
            f"({m.timestamp:.6f}) can{m.channel} {m.arbitration_id:03X}#{m.data.hex().upper()}\n" for m in sent
        )
    )


def candump_ta(path: Path, sent: list[can.Message]) -> None:
    path.write_text(
        "".join(
            f" ({m.timestamp:.6f})  can{m.channel}  {m.arbitration_id:03X}  [{m.dlc}]  {m.data.hex(' ').upper()}\n"
            for m in sent
        )
    )


def written_by(writer: type) -> Callable[[Path, list[can.Message]], None]:
    def write(path: Path, sent: list[can.Message]) -> None:
        log = writer(path)
        for message in sent:
            log.on_message_received(message)
        log.stop()

    return write


LOGS = {
    "candump.log": candump_l, "candump.txt": candump_ta, "a.asc": written_by(ASCWriter),
    "a.blf": written_by(BLFWriter), "a.trc": written_by(TRCWriter), "a.csv": written_by(CSVWriter),
}  # fmt: skip


@pytest.fixture
def described(tmp_path: Path) -> str:
    (tmp_path / "imu.dbc").write_text(DBC)
    (tmp_path / "imu.toml").write_text(MAP)
    return f"dbc={tmp_path / 'imu.dbc'}&map={tmp_path / 'imu.toml'}"


def replayed(path: Path, options: str) -> tuple[SampleBlock, Decoder]:
    address = parse_device_url(f"replay:{path}?{options}")
    port, data = open_port(address), b""
    try:
        while True:
            data += port.read(1000)
    except ReplayEnded:
        port.close()
    decoder = Decoder(can_format(address.dbc, address.map))
    return decoder.feed(data), decoder


@pytest.mark.parametrize("name", LOGS)
def test_every_form_of_log_gives_the_same_samples(name: str, tmp_path: Path, described: str) -> None:
    LOGS[name](tmp_path / name, messages())
    block, _ = replayed(tmp_path / name, described)
    assert len(block) == N
    assert np.allclose(block.gyro, [12.34, -0.05, 0.65])
    assert np.allclose(block.accel, [0.01, 0.02, 1.0])


@pytest.mark.parametrize("name", ["candump.log", "a.asc", "a.blf", "a.trc", "a.csv"])
def test_a_form_is_known_by_its_content_whatever_the_name(name: str, tmp_path: Path, described: str) -> None:
    LOGS[name](tmp_path / name, messages())
    (tmp_path / name).rename(tmp_path / "drive_7.dat")
    assert len(replayed(tmp_path / "drive_7.dat", described)[0]) == N


def test_the_logs_times_are_the_frames_host_times(tmp_path: Path, described: str) -> None:
    """Without a counter the samples' time is the host's: 10 ms apart as logged, however fast they are read."""
    mapping = (tmp_path / "imu.toml").read_text().replace('counter = "CNT"', 'first = "GYRO"')
    (tmp_path / "imu.toml").write_text(mapping)
    candump_l(tmp_path / "a.log", messages())
    block, _ = replayed(tmp_path / "a.log", described)
    assert np.allclose(np.diff(block.device_time), 0.01, atol=1e-6)
    assert block.device_time[0] == pytest.approx(EPOCH)


def test_frames_wanted_on_two_channels_are_asked_for(tmp_path: Path, described: str) -> None:
    path = tmp_path / "two.log"
    candump_l(path, [m for pair in zip(messages(0), messages(1, 777), strict=True) for m in pair])
    with pytest.raises(BadCanFile, match=r"channel=can0.*channel=can1") as error:
        replayed(path, described)
    assert "can0 (200 frames), can1 (200 frames)" in error.value.found
    block, _ = replayed(path, f"{described}&channel=can1")
    assert len(block) == N
    assert np.allclose(block.gyro[:, 0], 7.77)
    with pytest.raises(BadCanFile, match="can7"):
        replayed(path, f"{described}&channel=can7")


def test_other_devices_on_another_channel_are_no_question(tmp_path: Path, described: str) -> None:
    others = [can.Message(m.timestamp, 0x300, is_extended_id=False, data=b"x", channel=1) for m in messages()]
    candump_l(tmp_path / "a.log", [m for pair in zip(messages(), others, strict=True) for m in pair])
    block, decoder = replayed(tmp_path / "a.log", described)
    assert len(block) == N
    assert decoder.counters.foreign == 2 * N


def test_single_damaged_lines_cost_their_frames_alone(tmp_path: Path, described: str) -> None:
    candump_l(tmp_path / "a.log", messages())
    lines = (tmp_path / "a.log").read_text().splitlines()
    lines[20] = lines[20][:25] + lines[21]  # two run together
    (tmp_path / "a.log").write_text("\ufeff# recorded by hand\r\n\r\n" + "\r\n".join(lines) + "\r\n(17672")
    block, _ = replayed(tmp_path / "a.log", described)
    assert len(block) == N - 1


def test_many_damaged_lines_are_refused_with_the_first(tmp_path: Path, described: str) -> None:
    candump_l(tmp_path / "a.log", messages())
    lines = (tmp_path / "a.log").read_text().splitlines()
    (tmp_path / "a.log").write_text("\n".join(x[:25] if i % 20 == 3 else x for i, x in enumerate(lines)))
    with pytest.raises(BadCanFile) as error:
        replayed(tmp_path / "a.log", described)
    assert (error.value.line, error.value.found[:9]) == (4, "10 of 200")


def test_a_log_cut_in_the_middle_of_a_blf_is_refused(tmp_path: Path, described: str) -> None:
    LOGS["a.blf"](tmp_path / "a.blf", messages())
    content = (tmp_path / "a.blf").read_bytes()
    (tmp_path / "a.blf").write_bytes(content[:160] + b"\0" * 30 + content[190:])
    with pytest.raises(BadCanFile, match=r"a\.blf"):
        replayed(tmp_path / "a.blf", described)


def test_a_message_that_never_comes_is_named(tmp_path: Path, described: str) -> None:
    candump_l(tmp_path / "a.log", messages()[::2])
    with pytest.raises(BadCanFile, match="ACC") as error:
        replayed(tmp_path / "a.log", described)
    assert "0x101" in error.value.found


def test_a_sensor_that_the_device_lacks_is_left_out_of_the_mapping(tmp_path: Path, described: str) -> None:
    mapping = "".join(line for line in MAP.splitlines(keepends=True) if not line.startswith("accel"))
    (tmp_path / "imu.toml").write_text(mapping)
    candump_l(tmp_path / "a.log", messages()[::2])
    block, decoder = replayed(tmp_path / "a.log", described)
    assert len(block) == N
    assert decoder.kind.channels == {"gx", "gy", "gz"}
    assert not block.accel.any()


@pytest.mark.parametrize(
    ("text", "reported"),
    [
        ("".join(f"  can0  100   [8]  00 01 00 02 00 03 00 {i:02X}\n" for i in range(30)), "a.log"),
        ("date Thu Jan 01 00:00:00.0 2026\nbase hex  timestamps relative\n"
         "   0.010000 1  100             Rx   d 8 FB 2E 01 41 00 07 FD 85\n" * 3, "relative"),
    ],
)  # fmt: skip
def test_a_log_whose_times_cannot_be_known_is_refused(
    text: str, reported: str, tmp_path: Path, described: str
) -> None:
    (tmp_path / "a.log").write_text(text)
    with pytest.raises(BadCanFile, match=reported):
        replayed(tmp_path / "a.log", described)


def test_a_log_without_a_dbc_says_what_it_is_and_what_to_type(tmp_path: Path) -> None:
    candump_l(tmp_path / "a.log", messages())
    with pytest.raises(BadCanFile, match=r"dbc.*map"):
        open_port(f"replay:{tmp_path / 'a.log'}")


def test_two_j1939_devices_in_a_log_are_refused_before_any_sample(tmp_path: Path, described: str) -> None:
    wide = DBC.replace("BO_ 256", f"BO_ {0x8CF02AFE}").replace("BO_ 257", f"BO_ {0x88F02DFE}")
    (tmp_path / "imu.dbc").write_text(wide)
    sent = list[can.Message]()
    for source, begin in ((0x80, 0), (0x81, 100)):  # one after the other
        for m in messages():
            identifier = (0x0CF02A00 if m.arbitration_id == 256 else 0x08F02D00) | source
            sent.append(can.Message(m.timestamp + begin, identifier, data=m.data, channel=0))
    candump_l(tmp_path / "a.log", sent)
    text = (tmp_path / "a.log").read_text().replace(" CF02A", " 0CF02A").replace(" 8F02D", " 08F02D")
    (tmp_path / "a.log").write_text(text)
    with pytest.raises(BadCanFile, match=r"0x80.*0x81"):
        open_port(f"replay:{tmp_path / 'a.log'}?{described}")
