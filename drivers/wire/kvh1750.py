"""KVH 1750, 1725 and 1775, formats A, B and C, big-endian floats: a value per sample, not counts.

Source: KVH ICD 56-0298 rev. B. Gyros are rate or delta angle, in rad or degrees, accelerometers in g: the unit
is set to one or the other and no frame says which, so they are recorded as they come (``output = "rate"``, any
linear unit). Format A is the usual one; B adds a time stamp in us, without which host time stands in; C has a
slot that holds, by the sequence number modulo 4, temperature or the magnetic field's x, y, z. Temperature is
taken to be in degC, the default; 0.01 degC and Fahrenheit can be set and cannot be seen.

Other makers' boards open frames of other lengths with the same header: only the CRC makes a frame one.
"""

import numpy as np

from drivers.wire.checksums import mpeg2_crc, mpeg2_is_intact, seal
from drivers.wire.wire_format import FrameKind, Frames, WireFormat, fits
from procedures.counts.sample_records import RateBlock

HEADER = b"\xfe\x81\xff"
VALID = 0x77  # status: bits 0-2 gyros x y z, 4-6 accelerometers x y z; 3 and 7 are always 0
SEQUENCE_MODULUS = 128
TIME_MODULUS_US = 2**32
SLOTS = 4  # format C: 0 temperature, 1 2 3 magnetic x y z

_HEAD = [("header", "u1", 4), ("gyro", ">f4", 3), ("accel", ">f4", 3)]
_STATE = [("status", "u1"), ("sequence", "u1")]

FRAME_A = np.dtype([*_HEAD, *_STATE, ("temperature", ">i2"), ("crc", ">u4")])
FRAME_B = np.dtype([*_HEAD, ("time_us", ">u4"), *_STATE, ("temperature", ">i2"), ("crc", ">u4")])
FRAME_C = np.dtype([*_HEAD, ("slot", ">f4"), *_STATE, ("crc", ">u4")])

A = FrameKind(HEADER + b"\x55", FRAME_A, has_time=False)
B = FrameKind(HEADER + b"\x56", FRAME_B)
C = FrameKind(HEADER + b"\x57", FRAME_C, has_time=False)


def decode(frames: Frames) -> RateBlock:
    """Return the values; unhealthy where an axis is not valid or its value is no number."""
    gyro, accel = frames["gyro"].astype(np.float64), frames["accel"].astype(np.float64)
    status, sequence, names = frames["status"].astype(np.int64), frames["sequence"], frames.dtype.names or ()
    warmth = np.where(sequence % SLOTS == 0, frames["slot"], np.nan) if "slot" in names else frames["temperature"]
    finite = np.isfinite(gyro).all(axis=1) & np.isfinite(accel).all(axis=1)
    return RateBlock(
        counter=sequence.astype(np.int64) % SEQUENCE_MODULUS,
        device_time=frames["time_us"] / 1e6 if "time_us" in names else np.full(len(frames), np.nan),
        gyro=np.nan_to_num(gyro, posinf=0.0, neginf=0.0),
        accel=np.nan_to_num(accel, posinf=0.0, neginf=0.0),
        temperature=warmth.astype(np.float64),
        status=status,
        healthy=(status & VALID == VALID) & finite,
    )


def encode(block: RateBlock) -> bytes:
    """Return a block in format B: values as 32-bit floats, temperature to 1 degC, time modulo 2^32 us.

    All axes of an unhealthy sample are sent as not valid.
    """
    frames = np.zeros(len(block), FRAME_B)
    frames["header"] = np.frombuffer(B.prefix, np.uint8)
    frames["gyro"], frames["accel"] = block.gyro, block.accel
    frames["time_us"] = fits(np.rint(block.device_time * 1e6), 0, 2**62, "device_time in us") % TIME_MODULUS_US
    frames["status"] = np.where(block.healthy, VALID, 0)
    frames["sequence"] = fits(block.counter, 0, 2**63 - 1, "counter") % SEQUENCE_MODULUS
    frames["temperature"] = fits(np.rint(block.temperature), -(2**15), 2**15 - 1, "temperature")
    return seal(frames, mpeg2_crc)


FORMAT = WireFormat(
    name="kvh1750",
    title="KVH 1750, 1725, 1775, formats A, B and C",
    source="KVH ICD 56-0298 rev. B",
    length_at=None,
    imu=B,
    others=(A, C),
    check="CRC-32/MPEG-2 over everything before it",
    check_bits=32,
    is_intact=mpeg2_is_intact,
    decode=decode,
    encode=encode,
    carries=frozenset({"counter", "device_time", "temperature", "healthy"}),
    output="rate",
    temperature_step=1.0,
    counter_modulus=SEQUENCE_MODULUS,
    time_modulus=TIME_MODULUS_US / 1e6,
    baud=921600,
    # the values of a real frame of format A (tests/drivers/wire/test_kvh1750.py) at 1 s, made by `encode`
    example=bytes.fromhex(
        "fe81ff56 bc646c1e3c3ff9813b3c1e78 bc065fb7bb2fbd793f7e9800 000f4240 7747 0014 bf1cbc13"
    ),
)
FORMATS = (FORMAT,)
