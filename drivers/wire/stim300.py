"""Sensonor STIM300, normal mode, big-endian: 24-bit counts of gyros, accelerometers and inclinometers.

Source: datasheet TS1524 rev. 31, tables 5-11, 5-12, 5-20 to 5-23 and section 7.5.2.2. A datagram opens with its
identifier, which says what it holds and so how long it is; there is no sync word, CR LF may follow. The CRC-32 is
taken over zero bytes too, to a multiple of four, that are not sent.

The counter counts internal samples, 2000 a second, modulo 256: it is the device's time, which begins again every
0.128 s. PPS is the time since the last pulse at its input, where it is set to that. The latency says how much
later than that the datagram left. Set the unit to incremental output: what the counts are, angular rate or
increment, no datagram says. Status: 7 system integrity, 6 start-up, 5 outside operating conditions, 4 overload, 3
error in the channels of bits 2..0 (z, y, x).
"""

from types import MappingProxyType
from typing import Any

import numpy as np

from drivers.wire.checksums import mpeg2_crc, mpeg2_is_intact_padded, seal
from drivers.wire.wire_format import (
    FrameKind,
    Frames,
    NominalScale,
    PulseForm,
    WireFormat,
    fits,
)
from procedures.arrays import FloatArray, IntArray
from procedures.counts.sample_records import CountBlock
from procedures.units import RAD_PER_DEG

TICKS_HZ = 2000.0
COUNTER_MODULUS = 256  # ticks
INTEGRITY_BIT = 0x80
INT24 = 2**23
_TRIADS = {"g": "gyro", "a": "accel", "i": "incl"}
_WARM = {"G": "gyro", "A": "accel", "I": "incl"}

# What each holds besides the gyros: a accelerometers, i inclinometers, G A I temperatures, P PPS or AUX.
_HOLDS = {
    0x90: "", 0x91: "a", 0x92: "i", 0x93: "ai", 0x94: "G", 0xA5: "aGA", 0xA6: "iGI", 0xA7: "aiGAI",
    0x97: "aiGAI",  # of older firmware, as are the ones with AUX
    0x98: "P", 0x99: "aP", 0x9A: "iP", 0x9B: "aiP", 0x9C: "GP", 0x9D: "aGAP", 0x9E: "iGIP", 0x9F: "aiGAIP",
    0xAD: "aGAP", 0xAE: "iGIP", 0xAF: "aiGAIP",
    0xF0: "P", 0xF1: "aP", 0xF2: "iP", 0xF3: "aiP", 0xF4: "GP", 0xF5: "aGAP", 0xF6: "iGIP", 0xF7: "aiGAIP",
}  # fmt: skip


def _table(holds: str) -> np.dtype[np.void]:
    fields: list[Any] = [("id", "u1")]
    for letter in "g" + holds:
        if letter in _TRIADS:
            fields += [(_TRIADS[letter], "u1", (3, 3)), (f"{_TRIADS[letter]}_status", "u1")]
        elif letter in _WARM:
            fields += [(f"{_WARM[letter]}_temp", ">i2", 3), (f"{_WARM[letter]}_temp_status", "u1")]
        else:
            fields += [("pps", "u1", 3), ("pps_status", "u1")]
    # latency in us, from the sample to the datagram's first bit
    return np.dtype([*fields, ("counter", "u1"), ("latency", ">u2"), ("crc", ">u4")])


def _kind(identifier: int) -> FrameKind:
    holds = _HOLDS[identifier]
    channels = {"gx", "gy", "gz"} | ({"ax", "ay", "az"} if "a" in holds else set())
    return FrameKind(bytes((identifier,)), _table(holds), channels=frozenset(channels))


KINDS = {identifier: _kind(identifier) for identifier in _HOLDS}
FRAME = KINDS[0xAF].dtype


def int24(octets: np.ndarray[Any, np.dtype[np.uint8]]) -> IntArray:
    """Return ``octets`` (..., 3), big-endian 24-bit two's complement, as numbers (...,) int64."""
    high, middle, low = (octets[..., i].astype(np.int64) for i in range(3))
    value: IntArray = ((high ^ 0x80) - 0x80) << 16 | middle << 8 | low
    return value


def decode(frames: Frames) -> CountBlock:
    """Return the counts; 0 where a datagram has no accelerometers.

    The temperature is the mean of the gyros' three, unknown where their status is not 0. The status word holds,
    from the lowest byte: gyros, accelerometers, inclinometers, all the others; healthy are those whose first two
    are 0.
    """
    accel_status = _status(frames, "accel_status")
    gyro_status = _status(frames, "gyro_status")
    others = _status(frames, "gyro_temp_status", "accel_temp_status", "incl_temp_status", "pps_status")
    names, temperature = frames.dtype.names or (), np.full(len(frames), np.nan)
    if "gyro_temp" in names:
        is_known = frames["gyro_temp_status"] == 0
        temperature = np.where(is_known, frames["gyro_temp"].sum(axis=1) / 3 / 256, np.nan)
    return CountBlock(
        counter=np.full(len(frames), -1, dtype=np.int64),
        device_time=frames["counter"] / TICKS_HZ,
        gyro=int24(frames["gyro"]),
        accel=int24(frames["accel"]) if "accel" in names else np.zeros((len(frames), 3), dtype=np.int64),
        temperature=temperature,
        status=gyro_status | accel_status << 8 | _status(frames, "incl_status") << 16 | others << 24,
        healthy=np.asarray((gyro_status | accel_status) == 0),
    )


def _status(frames: Frames, *names: str) -> IntArray:
    word = np.zeros(len(frames), dtype=np.int64)
    for name in names:
        if name in (frames.dtype.names or ()):
            word |= frames[name]
    return word


def encode(block: CountBlock) -> bytes:
    """Return a block as datagrams AF: device time to 0.5 ms modulo 0.128 s, temperature to 2^-8 degC.

    An unhealthy sample says so by the gyros' system integrity bit; other status is not sent.
    """
    frames = np.zeros(len(block), FRAME)
    frames["id"] = IMU.prefix[0]
    for name, counts in (("gyro", block.gyro), ("accel", block.accel)):
        counts = fits(counts, -INT24, INT24 - 1, name)
        frames[name] = np.stack([counts >> shift & 0xFF for shift in (16, 8, 0)], axis=-1)
    frames["gyro_status"] = np.where(block.healthy, 0, INTEGRITY_BIT)
    unknown = np.isnan(block.temperature)
    warmth = fits(np.rint(np.where(unknown, 0.0, block.temperature) * 256), -(2**15), 2**15 - 1, "temperature")
    for name in _WARM.values():
        frames[f"{name}_temp"] = warmth[:, None]
        frames[f"{name}_temp_status"] = np.where(unknown, INTEGRITY_BIT, 0)
    ticks = fits(np.rint(block.device_time * TICKS_HZ), 0, 2**53, "device_time in ticks")
    frames["counter"] = ticks % COUNTER_MODULUS
    return seal(frames, lambda body: mpeg2_crc(bytes(body) + bytes(-len(body) % 4)))


IMU = KINDS[0xAF]
TIMED = {identifier: kind for identifier, kind in KINDS.items() if identifier >= 0xF0}  # PPS; before: AUX
MAX_PULSE_AGE_US = 1_500_000  # us: an older pulse is no longer one a second


def pulse_age(data: bytes) -> float | None:
    """Return how long [s] before the last sample in ``data`` a pulse came, as the field PPS has it in us.

    Source: TS1524 rev. 31, 7.5.2.2.15, equation 7: output "time since detection". None where the last datagram
    that is whole has no such field, its status is not 0, or the pulse is too old or not there (negative).
    """
    for at in range(len(data) - 1, -1, -1):
        kind = KINDS.get(data[at])
        if kind is not None and len(data) - at >= kind.size and mpeg2_is_intact_padded(data[at : at + kind.size]):
            if data[at] not in TIMED:
                return None
            (frame,) = np.frombuffer(data[at : at + kind.size], kind.dtype)
            age = int(int24(frame["pps"]))
            return age / 1e6 if frame["pps_status"] == 0 and 0 <= age <= MAX_PULSE_AGE_US else None
    return None


def with_pulses(block: CountBlock, ages: FloatArray) -> bytes:
    """Return a block as `encode` does, in datagrams F7, whose PPS holds ``ages`` (n,) [s]."""
    frames = np.frombuffer(encode(block), FRAME).copy()
    frames["id"] = 0xF7
    microseconds = fits(np.rint(ages * 1e6), 0, INT24 - 1, "time since the pulse in us")
    frames["pps"] = np.stack([microseconds >> shift & 0xFF for shift in (16, 8, 0)], axis=-1)
    return seal(frames, lambda body: mpeg2_crc(bytes(body) + bytes(-len(body) % 4)))


SHIFTS = {"STIM300 10 g": 22, "STIM300 5 g": 23, "STIM300 30 g": 21, "STIM300 80 g": 19}  # of the accelerometers
_GYRO, _RATE_HZ, _SAYS = 2.0**-21 * RAD_PER_DEG, 125.0, "TS1524 rev. 31, incremental output"
SCALES = {model: NominalScale(model, _GYRO, 2.0**-shift, _RATE_HZ, _SAYS) for model, shift in SHIFTS.items()}
FORMAT = WireFormat(
    name="stim300",
    title="Sensonor STIM300 normal mode",
    source="datasheet TS1524 rev. 31",
    length_at=None,
    imu=IMU,
    others=tuple(kind for kind in KINDS.values() if kind is not IMU),
    trailer=b"\r\n",
    check="CRC-32/MPEG-2 over everything before it and zero bytes to a multiple of 4",
    check_bits=32,
    is_intact=mpeg2_is_intact_padded,
    decode=decode,
    encode=encode,
    carries=frozenset({"device_time", "temperature", "healthy"}),
    count_bits=24,
    temperature_step=2.0**-8,
    time_modulus=COUNTER_MODULUS / TICKS_HZ,
    baud=921600,
    scales=MappingProxyType(SCALES),
    pulse=PulseForm(lambda data, sample_s: pulse_age(data), with_pulses),
    # of a real sensor: geirhovland/stim300 (MIT), README, whose printed values and CRC give these bytes
    example=bytes.fromhex(
        "af 000124fffad600035b00 ffe7a6ffdd36081c5200 ff7e70feba0c3ffa1d00 23a023c023a000 2319230a231c00"
        "239523b6239500 ffef0200 e1 01fa c64942c6"
    ),
)
FORMATS = (FORMAT,)
