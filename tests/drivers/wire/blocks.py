"""Samples that a wire format can hold, and their frames."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest

from drivers.framing import Decoder
from drivers.wire import FORMATS, WireFormat
from procedures.counts.sample_records import CountBlock, RateBlock, SampleBlock

PERIOD = 0.005
CHANNELS = {"gyro": ("gx", "gy", "gz"), "accel": ("ax", "ay", "az")}
FORWARD = 60.0  # s: device time that begins again sooner than this is compared modulo that


def each_format(has: Callable[[WireFormat], object] = lambda wire: True) -> pytest.MarkDecorator:
    """Run a test with every format of the table, or with those that have what it is about."""
    those = {name: wire for name, wire in FORMATS.items() if has(wire)}
    return pytest.mark.parametrize("wire", those.values(), ids=those)


def of_format(wire: WireFormat, n: int, gyro: Any, accel: Any, **columns: Any) -> SampleBlock:
    """Return a block of the type that the format decodes to, its channels those of the format; 0 elsewhere."""
    values = {}
    for name, given in (("gyro", gyro), ("accel", accel)):
        real = np.array([channel in wire.imu.channels for channel in CHANNELS[name]])
        values[name] = np.where(real, np.asarray(given).reshape(n, 3), 0)
    if wire.output == "rate":
        rates = {name: (value * 2.0**-20).astype(np.float32).astype(float) for name, value in values.items()}
        return RateBlock(**columns, **rates)
    keep = 32 - wire.count_bits  # the same counts with fewer bits
    return CountBlock(**columns, **{name: value.astype(np.int64) >> keep for name, value in values.items()})


def a_block(wire: WireFormat, n: int, start: int = 0, seed: int = 0, largest: int = 2**30) -> SampleBlock:
    """Return n consecutive samples, no two alike."""
    index, rng = np.arange(start, start + n), np.random.default_rng([start, seed])
    return of_format(
        wire,
        n,
        rng.integers(-largest, largest, (n, 3)),
        rng.integers(-(2**17), 2**17, (n, 3)),
        counter=index,
        device_time=1000 + index * PERIOD,
        temperature=np.full(n, 25.0),
        status=np.zeros(n, np.int64),
        healthy=np.ones(n, np.bool_),
    )


def frames_of(wire: WireFormat, block: SampleBlock) -> list[bytes]:
    """Return the frames of a block, each with what follows it on the line."""
    sent = wire.encode(block)
    if wire.imu.text is not None:
        return sent.splitlines(keepends=True)
    size = len(sent) // len(block)
    return [sent[at : at + size] for at in range(0, len(sent), size)]


def sync_of(wire: WireFormat) -> bytes:
    """Return what all kinds of frame begin with."""
    same = [len(set(octets)) == 1 for octets in zip(*wire.kinds, strict=True)]
    return wire.imu.prefix[: [*same, False].index(False)]


def bare(wire: WireFormat, frame: bytes) -> bytes:
    """Return a frame without what follows it."""
    return frame.removesuffix(wire.trailer) if wire.imu.text else frame


def decoded(wire: WireFormat, stream: bytes) -> SampleBlock:
    """Return the samples of a whole stream."""
    return Decoder(wire).feed(stream)


def row_of(wire: WireFormat, frame: bytes) -> np.ndarray:
    """Return a frame as a row of its table."""
    text = wire.imu.text
    return np.frombuffer(frame if text is None else text.row(bare(wire, frame)), wire.frame)


def assert_equal(wire: WireFormat, name: str, got: Any, sent: Any) -> None:
    """Compare a column of what was decoded with what was encoded, to the resolution that the format states."""
    if name == "counter":
        got, sent = got % (wire.counter_modulus or 1), sent % (wire.counter_modulus or 1)
    elif name == "temperature":
        np.testing.assert_allclose(got, sent, rtol=1e-12, atol=wire.temperature_step / 2, err_msg=name)
        return
    elif name == "device_time" and wire.time_modulus is not None:
        turn = wire.time_modulus
        assert ((got >= 0) & (got < turn)).all()
        np.testing.assert_allclose((got - sent + turn / 2) % turn, turn / 2, atol=1e-6)
        return
    elif name == "device_time" and wire.imu.text is not None:  # 9 decimals
        np.testing.assert_allclose(got, sent, rtol=0, atol=1e-9)
        return
    np.testing.assert_array_equal(got, sent, err_msg=name)


def gyro_of(blocks: Sequence[SampleBlock]) -> list[list[float]]:
    """Return the gyro values of blocks."""
    return np.concatenate([block.gyro for block in blocks]).tolist()
