"""A guided campaign next to the shipped scenario: its operator does what the guide asks for, without a command."""

import re
import signal
from collections import deque
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest

from drivers.camera import CameraDecoder, http_port
from drivers.framing import Decoder
from drivers.ports import open_port
from drivers.simulated.companions.truths import CameraTruth
from drivers.simulated.device import ByteDevice
from drivers.wire import FORMATS
from procedures.counts.sample_records import joined_blocks
from station import cli
from station.errors import DataRefused
from station.files.campaign_setup import Setup
from station.files.scenario import read_scenario
from station.guide.campaign.campaign_start import usual_steps
from station.guide.view import CalibrationView
from station.stream.camera import read_description
from tests.paths import ROOT
from tests.refusals import refused
from tests.station.commands.program import Program
from tests.station.guide.rig import GuideRig

SCENARIO = read_scenario(ROOT / "docs/scenarios/calibration.toml")
STEPS = usual_steps(Setup(dwell_s=20.0, revolutions=1))
ENOUGH = 4  # steps: the shock is in the fourth


def test_the_shipped_calibration_is_accepted_step_by_step_also_after_the_shock(tmp_path: Path) -> None:
    rig, moves = GuideRig(tmp_path, STEPS[:ENOUGH], SCENARIO.truth, asks=False), deque(SCENARIO.moves)

    def operate(_: CalibrationView) -> None:
        while moves and moves[0].at_s <= rig.source.device.imu.time:
            rig.hands(moves.popleft().command)

    rig.run(rig.done(ENOUGH), operate)
    rig.database.close()
    accepted = [text for text in rig.texts if text.startswith("accepted")]
    assert [f"position {n}, {n} of" in text for n, text in enumerate(accepted, 1)] == [True] * ENOUGH


DOCS = ROOT / "docs"
EXAMPLES = sorted((DOCS / "scenarios").glob("*.toml"))
SMALLEST = 'format = "scenario/1"\n'


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_the_shipped_examples_can_be_served_and_stand_on_the_page(path: Path) -> None:
    scenario = read_scenario(path)
    assert scenario.table.title
    assert scenario.moves or scenario.drive
    assert f"scenarios/{path.name}" in (DOCS / "how-to/testing.md").read_text(encoding="utf-8")


def test_moves_follow_each_other_and_happen_to_the_sample(tmp_path: Path) -> None:
    hands = (("rest 3", ""), ("place 3 5", ""), ("rest 1", ""), ("place 1", "at_s = 30"))
    text = "".join(f"[[hands]]\ndo = {do!r}\n{at}\n" for do, at in hands)
    (tmp_path / "s.toml").write_text(SMALLEST + text)
    scenario = read_scenario(tmp_path / "s.toml")
    settling_s = 12 * scenario.truth.settle_tau_s
    assert [move.at_s for move in scenario.moves] == pytest.approx([0, 3, 8 + settling_s, 30])
    device = ByteDevice(scenario.truth, 1, "counts", moves=scenario.moves)
    states = list[tuple[float, int, bool]]()
    while device.imu.time < 31:
        device.chunk(7)
        states.append((device.imu.time, device.imu.position, device.imu.is_moving))
    assert min(t for t, position, _ in states if position == 3) == pytest.approx(3, abs=0.15)
    assert not any(moving for t, _, moving in states if 9.5 + settling_s < t <= 30)
    assert [command for command, answer in device.moved if answer.startswith("ok")] == [
        move.command for move in scenario.moves
    ]


@pytest.mark.parametrize(
    ("text", "line", "value"),
    [
        ('format = "scenario/2"', 1, "scenario/2"), (f"{SMALLEST}sped = 2", 2, "sped"),
        (f"{SMALLEST}[imu]\ntransport = 'pigeon'", 3, "pigeon"), (f"{SMALLEST}[imu]\nport = 5", 2, "5"),
        (f"{SMALLEST}[imu]\nformat = 'x'", 2, "format = 'x'"),
        (f"{SMALLEST}[gnss]\ntransport = 'udp'\nlink = 'dev'", 2, "gnss"),
        (f"{SMALLEST}[gnss]\nto = 'here'", 2, "here"),
        (f"{SMALLEST}[truth]\nserial = 'S'\ncolour = 1", 4, "colour"),
        (f"{SMALLEST}[truth]\naccel_k = [1, 2]", 3, "accel_k"),
        (SMALLEST + '\n[truth.effects."gyroscope.luck"]\nx = 1', 4, "gyroscope.luck"),
        (f"{SMALLEST}[[hands]]\ndo = 'place 3'\n[[hands]]\n\ndo = 'fly'", 6, "fly"),
        (f"{SMALLEST}[[hands]]\ndo = 'turn y + 1'", 3, "turn y + 1"),
        (f"{SMALLEST}[[hands]]\ndo = 'time'", 3, "time"),
        (f"{SMALLEST}[[hands]]\ndo='rest 9'\n[[hands]]\ndo='rest 1'\nat_s=5.0", 6, "at_s = 5"),
        (f"{SMALLEST}[[fault]]\nkind='lost'\nat_s=1\n[[fault]]\nkind='babble'\nat_s=1", 5, "babble"),
        (f"{SMALLEST}[[fault]]\nkind='lost'", 2, "at_s"),
        (f"{SMALLEST}[[gnss_fault]]\nkind='jump'\nat_s=1", 2, ""),
        (f"{SMALLEST}[gnss]\n[gnss.autopilot]\nkey = 'nofile'", 4, "nofile"),
        (f"{SMALLEST}[camera]\n[[camera_fault]]\nkind='luck'\nat_s=1", 3, "luck"),
        (f"{SMALLEST}[camera]\nwidth = 1", 3, "width"),
        (f"{SMALLEST}[camera]\nimu_from_camera = [[1.0]]", 3, "[1.0]"),
        (SMALLEST + f"[camera]\nimu_from_camera = {[[1.0] * 4] * 4}", 3, "imu_from_camera"),
        (f"{SMALLEST}[imu]\ntrack = 's.toml'", 3, ""), (f"{SMALLEST}speed =\nseed = 1", 2, "TOML"),
    ],
)  # fmt: skip
def test_a_bad_file_is_refused_with_its_line(text: str, line: int, value: str, tmp_path: Path) -> None:
    path = tmp_path / "s.toml"
    path.write_text(text)
    with refused(DataRefused, None, value, line=line, file=str(path)):
        read_scenario(path)
    assert cli.run(["simulate", "--scenario", str(path)]) == 3


def test_a_bench_is_served_and_reports_what_happens(tmp_path: Path) -> None:
    text = 'speed = 50\n[imu]\ntransport = "tcp"\n[gnss]\n[[hands]]\ndo = "place 3 5"\nat_s = 2\n'
    (tmp_path / "s.toml").write_text(SMALLEST + text + '[[fault]]\nkind = "lost"\nat_s = 4\n')
    with Program("simulate", "--scenario", str(tmp_path / "s.toml")) as program:
        reported = "".join(program.until("control "))
        (url,) = re.findall(r"^url (tcp:\S+)$", reported, re.MULTILINE)
        assert re.search(r"^gnss mavlink:udpout:127.0.0.1:\d+$", reported, re.MULTILINE)
        with Program("record", url, "--seconds", "10", "--out", str(tmp_path / "r")) as other:
            assert other.end()[0] == 0
        program.process.send_signal(signal.SIGINT)
        code, _, stated = program.end()
    assert code == 0
    assert re.findall(r"^ *(\d+\.\d) s  (.*)$", stated, re.MULTILINE) == [
        ("2.0", "hands: place 3 5"), ("4.0", "fault: lost"),
    ]  # fmt: skip


def test_imu_receiver_and_camera_go_along_one_track(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("cv2", reason="opencv is not installed")
    monkeypatch.setattr(http_port, "SILENT_S", 100.0)  # on a machine however loaded
    scenario = read_scenario(DOCS / "scenarios/drive.toml")
    assert scenario.drive is scenario.track
    assert scenario.camera is not None
    assert np.array_equal(scenario.camera.C_bc, CameraTruth().C_bc)
    text = (DOCS / "scenarios/drive.toml").read_text(encoding="utf-8")
    (tmp_path / "s.toml").write_text(text.replace("drive.csv", str(DOCS / "scenarios/drive.csv")))
    eye = tmp_path / "eye.toml"
    with Program(
        "simulate", "--scenario", str(tmp_path / "s.toml"), "--speed", "4", "--camera-file", str(eye)
    ) as program:
        reported = "".join(program.until("control "))
        (imu,) = re.findall(r"^url (tcp:\S+)$", reported, re.MULTILINE)
        (camera,) = re.findall(r"^camera (camera:http://127.0.0.1:\d+/stream)$", reported, re.MULTILINE)
        assert read_description(eye).address.text == camera
        with closing(open_port(camera)) as seen, closing(open_port(imu)) as felt:
            wire, cameras, images, samples = Decoder(FORMATS["counts"]), CameraDecoder(), [], []
            while len(images) < 3:  # one clock for all: it goes on while the IMU is read
                samples.append(wire.feed(felt.read(4096)))
                images += cameras.feed(seen.read(2**20), 0)
        program.process.send_signal(signal.SIGINT)
        assert program.end()[0] == 0
    last_s = joined_blocks(samples).device_time[-1]
    assert 0 <= images[-1].device_ns / 1e9 - scenario.camera.clock_offset_s < last_s + 1.0


def test_the_example_can_be_served() -> None:
    scenario = read_scenario(DOCS / "scenarios/example.toml")
    assert [move.at_s for move in scenario.moves[:2]] == pytest.approx([20, 30 + 12 * scenario.truth.settle_tau_s])
    assert scenario.autopilot is not None
    assert scenario.autopilot.system == 5
