"""Room on the disk: looked at before a campaign begins, measured by sample; a full or slow disk is said."""

import errno
import os
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from drivers.framing import Decoder
from drivers.simulated.device import ByteDevice
from drivers.simulated.truth import Truth
from drivers.wire import FORMATS
from fixtures_db.database import Database
from procedures.counts.sample_records import CountBlock, SampleBlock, block_rows
from procedures.errors import ErrorCode
from station.errors import DiskFull
from station.files.campaign_setup import Setup
from station.files.mcap_files import BY_OUTPUT, StepWriter
from station.files.mcap_files.gnss_file import FixWriter
from station.files.mcap_files.schemas import RAW_TOPIC
from station.guide import server
from station.guide.campaign.campaign_start import usual_steps
from station.guide.campaign.folder_recorder import RAW_BYTES, STEP_BYTES, disk_needed, refuse_full
from station.guide.engine import CalibrationEngine
from station.guide.options import CalibrationOptions
from station.guide.server import StallNotice
from station.guide.view import CalibrationView
from station.stream.reader import Chunk
from station.stream.reader.raw_recording import RawRecording
from station.stream.recorder.sample_stream import SampleStream
from tests.patience import until
from tests.refusals import refused

SAMPLES = 1000
GNSS_EPOCH_NS = 1_800_000_000_000_000_000
WHOLE_IMUS = [name for name, wire in FORMATS.items() if len(wire.imu.channels) == 6]


def noisy(block: SampleBlock, bits: int, rng: np.random.Generator) -> SampleBlock:
    """Give every channel 16 random bits, or what the format holds."""
    if isinstance(block, CountBlock):
        most = 2 ** (min(16, bits - 2) - 1)
        noise = [rng.integers(-most, most, (len(block), 3)) for _ in range(2)]
        return replace(block, gyro=block.gyro // 8 + noise[0], accel=block.accel // 8 + noise[1])
    noise = [rng.normal(0, 1e-3, (len(block), 3)) for _ in range(2)]
    return replace(block, gyro=block.gyro + noise[0], accel=block.accel + noise[1])


@pytest.mark.parametrize("name", WHOLE_IMUS[::2])
def test_no_sample_of_any_format_takes_more_than_is_reckoned(name: str, tmp_path: Path) -> None:
    wire, rng, chunks = FORMATS[name], np.random.default_rng(1), list[Chunk]()
    device, decoder, stream = ByteDevice(Truth.example(1), 1, name), Decoder(wire), SampleStream(wire)
    while len(chunks) < SAMPLES:
        block = decoder.feed(b"".join(part for part in device.chunk() if isinstance(part, bytes)))
        for row in range(len(block)):
            one = noisy(block_rows(block, slice(row, row + 1)), wire.count_bits, rng)
            host_ns = GNSS_EPOCH_NS + len(chunks) * 1_000_000 + int(rng.integers(100_000))
            chunks.append(Chunk(host_ns, wire.encode(one)))
    blocks, number = [stream.take(chunk).block for chunk in chunks], len(chunks)
    recording = RawRecording(tmp_path / "recording.mcap", {}, pytest.fail, RAW_TOPIC)  # flushes by the wall clock
    writer = StepWriter(tmp_path / "step.mcap", BY_OUTPUT[wire.output])
    for chunk, block in zip(chunks, blocks, strict=True):
        recording.put(chunk)
        writer.write_raw(chunk.host_ns, chunk.data)
        writer.write_block(chunk.host_ns, block)
    recording.close()
    writer.close()
    assert RAW_BYTES / 2 < (tmp_path / "recording.mcap").stat().st_size / number <= RAW_BYTES
    assert STEP_BYTES / 2 < (tmp_path / "step.mcap").stat().st_size / number <= STEP_BYTES


def test_what_a_campaign_needs_grows_with_its_length_and_its_rate() -> None:
    short, long = usual_steps(Setup(dwell_s=10)), usual_steps(Setup(dwell_s=200))
    assert disk_needed(short, 200) < disk_needed(long, 200) < disk_needed(long, 2000)
    assert 50e6 < disk_needed(usual_steps(Setup()), 200) < 300e6


def test_a_campaign_that_has_no_room_is_refused_with_both_figures(tmp_path: Path) -> None:
    steps = usual_steps(Setup(dwell_s=1e9))
    with refused(DiskFull, ErrorCode.DISK_FULL, "MB free", "MB needed"):
        refuse_full(tmp_path, steps, 200)


def test_what_cannot_be_closed_either_is_reported_once(
    db: Database, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(_: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    writer = FixWriter(tmp_path / "gnss_1.mcap")
    engine = CalibrationEngine(db, CalibrationOptions(tmp_path), lambda view: None)
    room = SimpleNamespace(needed=5_000_000, free=0)
    engine._campaign = SimpleNamespace(disk=room, close=writer.close)  # type: ignore[assignment]  # noqa: SLF001
    monkeypatch.setattr(os, "fsync", refuse)
    engine._fail(DiskFull(tmp_path))  # noqa: SLF001
    assert engine.view.stage == "failed"
    assert "5 MB needed" in engine.view.error


@pytest.fixture(autouse=True)
def quick(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(server, "STALL_S", 0.05)
    monkeypatch.setattr(server, "LOOK_S", 0.01)


def test_a_round_that_lasts_is_reported_and_no_other() -> None:
    view, seen = CalibrationView(stage="dwell", line="position 3", hint="still"), list[CalibrationView]()
    with StallNotice(lambda: view, seen.append) as watch:
        with watch.round():
            until(lambda: bool(seen))
        reported = len(seen)
        with watch.round():
            pass
        assert len(seen) <= reported + 1
    assert seen[0].line == "position 3"
    assert "writing to the disk for " in seen[0].hint
    assert "accepted steps are safe" in seen[0].hint


@pytest.mark.parametrize("stage", ["solving", "connecting", "verdict", "failed"])
def test_what_says_itself_what_it_does_is_left_alone(stage: str) -> None:
    view, seen, looks = CalibrationView(stage=stage), list[CalibrationView](), list[int]()  # type: ignore[arg-type]

    def shown() -> CalibrationView:
        looks.append(1)
        return view

    with StallNotice(shown, seen.append) as watch, watch.round():
        until(lambda: len(looks) > 10)
    assert seen == []
