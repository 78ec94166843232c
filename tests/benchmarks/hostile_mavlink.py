"""Feed damaged MAVLink frames to the framer and to records."""

import random
from typing import Any
from unittest.mock import patch

from pymavlink.dialects.v20 import all as dialect

from drivers.mavlink import frames as mavlink_frames
from drivers.mavlink.gnss_fixes import MavlinkDecoder
from tests.benchmarks.damage import CONTROL_BITS, DAMAGES, Outcome, Shape, counted, damaged, passes_control
from tests.proof.evidence import Figure

BATCH = 2000
BITS = 16
SHAPE = Shape((b"\xfd", b"\xfe"), 10, 60)


def a_sender() -> Any:
    """Return pymavlink's own encoder."""
    return dialect.MAVLink(None, srcSystem=1, srcComponent=1)


def some_frames(rng: random.Random, mav: Any, n: int) -> list[bytes]:
    """Return n frames of the messages that are read here, in sequence."""
    made = []
    for _ in range(n):
        where = rng.randrange(-(2**31), 2**31), rng.randrange(-(2**31), 2**31), rng.randrange(-(2**20), 2**20)
        stamp, u16 = rng.randrange(1, 2**50), [rng.randrange(2**16) for _ in range(4)]
        message = rng.choice(
            (
                lambda: mav.gps_raw_int_encode(stamp, rng.randrange(9), *where, *u16, 12, 5, 1, 2, 3, 4, 77),  # noqa: B023
                lambda: mav.global_position_int_encode(stamp % 2**32, *where, 0, 1, -2, 3, 100),  # noqa: B023
                lambda: mav.system_time_encode(stamp, stamp % 2**32),  # noqa: B023
                lambda: mav.heartbeat_encode(2, 3, 81, stamp % 2**32, 4),  # noqa: B023
                lambda: mav.vfr_hud_encode(rng.random(), 1.0, 90, 50, 100.0, rng.random()),
            )
        )()
        made.append(bytes(message.pack(mav)))
        mav.seq = (mav.seq + 1) % 256
    return made


def _false_frame(rng: random.Random, frame: bytes, _: bytes, shape: Shape) -> bytes:
    return frame[: shape.head] + rng.randbytes(len(frame) - shape.head)


def attack(frames: int, seed: int, bits: int = BITS) -> Outcome:
    """Feed ``frames`` damaged frames and return what was counted."""
    name = "mavlink" if bits == BITS else f"mavlink-cut-to-{bits}-bits"
    got, rng, mav = Outcome(name, bits), random.Random(seed), a_sender()
    accepted: list[bytes] = []
    decoder = MavlinkDecoder()
    wanted = decoder.framer._is_wanted  # noqa: SLF001

    def spy(raw: bytes, frame: mavlink_frames.Frame) -> bool:
        accepted.append(raw)
        return wanted(raw, frame)

    decoder.framer._is_wanted = spy  # noqa: SLF001
    while got.mutated < frames:
        accepted.clear()
        pool = some_frames(rng, mav, min(BATCH, frames - got.mutated))
        pieces, intact = damaged(rng, pool, SHAPE, (*DAMAGES, _false_frame))
        got.mutated += len(pool)
        got.feed(rng, b"".join(pieces) + bytes(300), lambda part: decoder.feed(part, 0))
        got.count(accepted, set(pool), [pool[index] for index in intact])
    got.checks_failed = decoder.framer.counters.bad_crc
    return got


class _AnyCheck(int):
    """A check that equals whatever was sent."""

    def __ne__(self, other: object) -> bool:
        return False


def with_weak_check(frames: int, seed: int) -> Outcome:
    """Return the outcome with the check as good as cut to 8 bits."""
    full = mavlink_frames.crc
    with patch.object(mavlink_frames, "crc", lambda *of: _AnyCheck() if passes_control(of[0]) else full(*of)):
        return attack(frames, seed, CONTROL_BITS)


def proof(size: int, seed: int) -> dict[str, Figure]:
    """Feed ``size`` damaged frames, and as many to the control."""
    return counted(attack(size, seed)) | counted(with_weak_check(min(size, 200_000), seed))
