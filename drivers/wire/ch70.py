"""CH-70 closed-loop fibre-optic gyro, one axis: counts in groups of seven bits, 10 bytes a sample.

Source: the maker's specification sheet and receiver (PROTOCOLS: STM32_GYRO). RS-422, 115200 baud, 8E1, 400 Hz.
Only the header has bit 7 set, so the stream finds itself again at once; but a 7-bit XOR lets 1 damaged frame in
128 through. What passes is looked at again: a value that steps further than a gyro can is marked unhealthy.
There is no counter, no time and no status: a lost frame is seen by the rate alone. It measures one axis, given
as x.
"""

from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from drivers.wire.wire_format import FrameKind, Frames, NominalScale, Octets, WireFormat, fits
from procedures.arrays import IntArray
from procedures.counts.sample_records import CountBlock
from procedures.units import RAD_PER_DEG

HEADER = 0x80
GROUP_BITS = 7  # bits
INT32 = 2**31
TEMPERATURE_COUNTS = 16  # counts per degC
RATE_HZ = 400.0
MAX_STEP = 2**18  # counts: 5.6 deg/s in 2.5 ms, 2230 deg/s^2

FRAME = np.dtype(
    [
        ("header", "u1"),
        ("count", "u1", 5),  # int32 two's complement, least significant group first; the fifth holds D31..D28
        ("count_xor", "u1"),
        ("temperature", "u1", 2),  # 14 bits two's complement, least significant group first
        ("temperature_xor", "u1"),
    ]
)


def is_intact(frame: Octets) -> bool:
    """Say whether a frame passes both XORs and has bit 7 in its header only."""
    head, a, b, c, d, e, x, s, t, y = frame
    return (
        head == HEADER
        and a ^ b ^ c ^ d ^ e == x
        and s ^ t == y
        and (a | b | c | d | s | t | x | y) < HEADER
        and e < 16  # D31..D28
    )


def decode(frames: Frames) -> CountBlock:
    """Return the counts as gyro x; the other channels are 0."""
    n = len(frames)
    gyro = np.zeros((n, 3), dtype=np.int64)
    gyro[:, 0] = _joined(frames["count"], 32)
    return CountBlock(
        counter=np.full(n, -1, dtype=np.int64),
        device_time=np.full(n, np.nan),
        gyro=gyro,
        accel=np.zeros((n, 3), dtype=np.int64),
        temperature=_joined(frames["temperature"], 14) / TEMPERATURE_COUNTS,
        status=np.zeros(n, dtype=np.int64),
        healthy=np.ones(n, dtype=np.bool_),
    )


def encode(block: CountBlock) -> bytes:
    """Return the frames of a block: gyro x, and the temperature to 1/16 degC; nothing else is sent."""
    frames = np.zeros(len(block), FRAME)
    frames["header"] = HEADER
    warmth = fits(np.rint(block.temperature * TEMPERATURE_COUNTS), -(2**13), 2**13 - 1, "temperature in 1/16 degC")
    count = fits(block.gyro[:, 0], -INT32, INT32 - 1, "gyro")
    for name, value, bits in (("count", count, 32), ("temperature", warmth, 14)):
        shifts = GROUP_BITS * np.arange(frames[name].shape[1])
        frames[name] = (value & 2**bits - 1)[:, None] >> shifts & 0x7F
        frames[f"{name}_xor"] = np.bitwise_xor.reduce(frames[name], axis=1)
    return frames.tobytes()


def _joined(groups: NDArray[np.uint8], bits: int) -> IntArray:
    """Return numbers of ``bits`` two's complement."""
    half = 1 << bits - 1
    joined = (groups.astype(np.int64) << GROUP_BITS * np.arange(groups.shape[1])).sum(axis=1)
    signed: IntArray = (joined & 2**bits - 1 ^ half) - half
    return signed


REPORT = "maker's test report, unit 19036, mean of 3"
SCALE = NominalScale("CH-70", RAD_PER_DEG / 47019 / RATE_HZ, np.nan, RATE_HZ, REPORT)
FORMAT = WireFormat(
    name="ch70",
    title="CH-70 single-axis fibre-optic gyro",
    source="maker's specification sheet of the CH-70",
    length_at=None,
    imu=FrameKind(bytes((HEADER,)), FRAME, channels=frozenset({"gx"}), has_time=False),
    check="XOR of the count's five groups, and of the temperature's two; bit 7 in the header only",
    check_bits=7,
    is_intact=is_intact,
    max_step=MAX_STEP,
    decode=decode,
    encode=encode,
    carries=frozenset({"temperature"}),
    temperature_step=1 / TEMPERATURE_COUNTS,
    baud=115200,
    parity="E",
    scales=MappingProxyType({SCALE.model: SCALE}),
    example=bytes.fromhex("802f6f02000042100313"),  # 1 deg/s at 25 degC, from the sheet's table
)
FORMATS = (FORMAT,)
