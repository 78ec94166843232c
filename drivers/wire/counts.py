"""The station's own frame for a rig or an FPGA that emits counts, little-endian.

Source: docs/reference/wire-format-counts.md, written so that the sender can be built from that page alone.
Two kinds of frame share one sync: an IMU frame per sample and an identity frame about once a second.
"""

import zlib

import numpy as np

from drivers.wire.checksums import seal
from drivers.wire.wire_format import FrameKind, Frames, Identity, Octets, WireFormat, fits
from procedures.counts.sample_records import CountBlock

SYNC = b"\xeb\x90"  # IRIG 106's 16-bit frame synchronisation pattern: few partial matches with itself
NO_TEMPERATURE = -32768
FAULT_BITS = 0x00FF  # status bits 0-7 say that the counts cannot be trusted; 8-15 only inform
INTERNAL_FAULT = 0x0080
RESIDUE = 0x2144DF1C  # CRC-32/ISO-HDLC of any message followed by its own CRC
INT32 = 2**31

HEAD = [("sync", "u1", 2), ("kind", "u1"), ("length", "u1")]  # length of the whole frame
FRAME = np.dtype(
    [
        *HEAD,
        ("counter", "<u4"),  # one more with every sample taken, sent or not
        ("time_ns", "<u8"),  # device clock at the end of the sample's interval
        ("gyro", "<i4", 3),  # angle increments x, y, z
        ("accel", "<i4", 3),  # velocity increments x, y, z
        ("temperature", "<i2"),  # 0.01 degC
        ("status", "<u2"),
        ("crc", "<u4"),
    ]
)

IDENTITY = np.dtype(
    [
        *HEAD,
        ("period_ns", "<u4"),  # nominal sample period; 0 = not stated
        ("model", "S24"),  # printable ASCII, padded with zero bytes
        ("serial", "S24"),
        ("crc", "<u4"),
    ]
)


def is_intact(frame: Octets) -> bool:
    """Say whether a frame passes its CRC-32/ISO-HDLC (Ethernet, zlib)."""
    return zlib.crc32(frame) == RESIDUE


def decode(frames: Frames, fault_bits: int = FAULT_BITS) -> CountBlock:
    """Return the counts, 0 of a triad that a frame has not; unhealthy where any of the fault bits is set."""
    temperature, status = frames["temperature"], frames["status"].astype(np.int64)
    nothing = np.zeros((len(frames), 3))
    has_accel = "accel" in (frames.dtype.names or ())
    return CountBlock(
        counter=frames["counter"].astype(np.int64),
        device_time=frames["time_ns"] / 1e9,
        gyro=frames["gyro"].astype(np.int64),
        accel=(frames["accel"] if has_accel else nothing).astype(np.int64),
        temperature=np.where(temperature == NO_TEMPERATURE, np.nan, temperature / 100.0),
        status=status,
        healthy=(status & fault_bits) == 0,
    )


def encode(block: CountBlock) -> bytes:
    """Return the frames of a block; counters are taken modulo 2^32, temperatures rounded to 0.01 degC.

    An unhealthy sample without a fault bit is sent with bit 7, internal fault.
    """
    return encode_as(IMU, block, FAULT_BITS, INTERNAL_FAULT)


def encode_as(kind: FrameKind, block: CountBlock, fault_bits: int, default_fault: int) -> bytes:
    """Return a block in frames of a kind; an unhealthy sample without a fault bit gets ``default_fault``."""
    frames = np.zeros(len(block), kind.dtype)
    frames["sync"] = np.frombuffer(kind.prefix[:2], np.uint8)
    frames["kind"], frames["length"] = kind.prefix[2:4]
    frames["counter"] = fits(block.counter, 0, 2**63 - 1, "counter") % 2**32
    frames["time_ns"] = fits(np.rint(block.device_time * 1e9), 0, 2**62, "device_time in ns")
    for name in sorted(kind.triads, reverse=True):
        frames[name] = fits(getattr(block, name), -INT32, INT32 - 1, name)
    unknown = np.isnan(block.temperature)
    hundredths = np.rint(np.where(unknown, 0.0, block.temperature) * 100)
    frames["temperature"] = np.where(
        unknown, NO_TEMPERATURE, fits(hundredths, -32767, 32767, "temperature in 0.01 degC")
    )
    status = fits(block.status, 0, 2**16 - 1, "status")
    frames["status"] = status | np.where(~block.healthy & ((status & fault_bits) == 0), default_fault, 0)
    return seal(frames, zlib.crc32)


def identify(frame: bytes) -> Identity:
    """Return who the sender is; bytes that are not printable ASCII become question marks."""
    row = np.frombuffer(frame, IDENTITY)[0]
    return Identity(_text(row["model"]), _text(row["serial"]), int(row["period_ns"]) / 1e9)


def _text(raw: bytes) -> str:
    return "".join(chr(octet) if 0x20 <= octet < 0x7F else "?" for octet in raw)


def encode_identity(identity: Identity) -> bytes:
    """Return an identity frame; raise ValueError where model or serial is not 24 bytes of printable ASCII."""
    frame = np.zeros(1, IDENTITY)
    frame["sync"] = np.frombuffer(SYNC, np.uint8)
    frame["kind"], frame["length"] = IDENTIFY.prefix[2:4]
    frame["period_ns"] = fits(np.rint(np.array([identity.period * 1e9])), 0, 2**32 - 1, "period in ns")
    for name, text in (("model", identity.model), ("serial", identity.serial)):
        if len(text) > 24 or not (text.isascii() and (text.isprintable() or not text)):
            raise ValueError(f"{name} is {text!r}, expected at most 24 printable ASCII characters")
        frame[name] = text.encode("ascii")
    return seal(frame, zlib.crc32)


IMU = FrameKind(prefix=SYNC + bytes((1, FRAME.itemsize)), dtype=FRAME)
IDENTIFY = FrameKind(prefix=SYNC + bytes((2, IDENTITY.itemsize)), dtype=IDENTITY)

FORMAT = WireFormat(
    name="counts",
    title="Counts of a rig or FPGA, version 1",
    source="docs/reference/wire-format-counts.md",
    length_at=3,
    imu=IMU,
    check="CRC-32/ISO-HDLC (Ethernet, zlib) over everything before it",
    check_bits=32,
    is_intact=is_intact,
    decode=decode,
    encode=encode,
    carries=frozenset({"counter", "device_time", "temperature", "status", "healthy"}),
    baud=921600,
    counter_modulus=2**32,
    identity=IDENTIFY,
    identify=identify,
    encode_identity=encode_identity,
    example=bytes.fromhex(
        "eb900130 04030201 141a99be1c000000 01000000 feffffff 78563412"
        "ffffffff 14000000 00000080 e909 0001 933a2d85"
    ),
)
FORMATS = (FORMAT,)
