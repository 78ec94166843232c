"""Feed damaged frames to every decoder.

Every damaged frame is followed by an intact one with chance 1/8. Counted: crashes, accepted frames that differ
from every one sent, and intact frames not found. Beside the wrong ones stands what the check's width allows:
2^-bits per frame whose check was computed and failed. A control cuts the check to 8 bits: there wrong
frames must come out at about the rate expected, or this proof could not see any.

An intact frame may be lost honestly: where the frame before it was cut by bytes that happen to equal the sync,
the decoder completes that one and finds the intact one headless.
"""

import random
import sys
import zlib
from dataclasses import replace

import numpy as np

from drivers.framing import Decoder
from drivers.wire import FORMATS, FrameKind, WireFormat
from procedures.counts.sample_records import SampleBlock
from tests.benchmarks.damage import CONTROL_BITS, DAMAGES, Outcome, Shape, counted, cuts, damaged
from tests.drivers.wire import blocks
from tests.drivers.wire.blocks import bare, frames_of
from tests.proof.evidence import Figure, spread

BATCH = 2000


def a_block(wire: WireFormat, n: int, rng: np.random.Generator) -> SampleBlock:
    """Return n samples, no two alike, whose steps the unit can make."""
    largest = 2**30 if wire.max_step is None else wire.max_step // 2
    return blocks.a_block(wire, n, start=int(rng.integers(0, 2**31)), largest=largest)


def false_frame(rng: random.Random, wire: WireFormat) -> bytes:
    """Return a frame of noise behind a true prefix."""
    kind: FrameKind = rng.choice(list(wire.kinds.values()))
    if kind.text is not None:
        return (
            kind.prefix
            + rng.randbytes(rng.randrange(20, 120)).hex(",").encode()
            + b"*"
            + rng.randbytes(4).hex().encode()
        )
    return kind.prefix + rng.randbytes(kind.size - len(kind.prefix))


def shape_of(wire: WireFormat) -> Shape:
    """Return what damage to a format's frames aims at."""
    return Shape((wire.sync, wire.imu.prefix), len(wire.imu.prefix), wire.imu.size)


def attack(wire: WireFormat, frames: int, seed: int, bits: int) -> Outcome:
    """Feed ``frames`` damaged frames and return what was counted."""
    outcome, rng, numbers = Outcome(wire.name, bits), random.Random(seed), np.random.default_rng(seed)
    ways = (*DAMAGES, lambda rng, *_: false_frame(rng, wire))
    accepted: list[bytes] = []

    def spy(found: np.ndarray) -> SampleBlock:
        accepted.extend(frame.tobytes() for frame in found)
        return wire.decode(found)

    decoder = Decoder(replace(wire, decode=spy))
    while outcome.mutated < frames:
        pool = frames_of(wire, a_block(wire, BATCH, numbers))
        accepted.clear()
        Decoder(replace(wire, decode=spy)).feed(b"".join(pool))
        known = set(accepted)
        assert len(accepted) == len(pool)
        accepted.clear()
        pool = pool[: frames - outcome.mutated]
        pieces, intact = damaged(rng, pool, shape_of(wire), ways)
        outcome.mutated += len(pool)
        try:
            for part in cuts(rng, b"".join(pieces)):
                decoder.feed(part)
            decoder.finish()
        except Exception as error:  # whatever it is, it is a crash
            outcome.crashes += 1
            print(f"{wire.name}: {error!r}", file=sys.stderr)
            decoder = Decoder(replace(wire, decode=spy))
            continue
        got = set(accepted)
        outcome.intact += len(intact)
        outcome.accepted += len(accepted)
        outcome.wrong += sum(frame not in known for frame in accepted)
        rows = [row.tobytes() for row in rows_of(wire, [pool[index] for index in intact])]
        outcome.lost += sum(row not in got for row in rows)
    outcome.wrong += decoder.counters.identities  # none was sent
    outcome.checks_failed = decoder.counters.bad_crc
    return outcome


def rows_of(wire: WireFormat, frames: list[bytes]) -> np.ndarray:
    """Return intact frames as rows of the format's table."""
    text = wire.imu.text
    return np.frombuffer(
        b"".join(bare(wire, frame) if text is None else text.row(bare(wire, frame)) for frame in frames),
        wire.frame,
    )


def with_weak_check(wire: WireFormat) -> WireFormat:
    """Return the format with its check as good as cut to 8 bits."""
    salt = b"control"
    mask = 2**CONTROL_BITS - 1

    def is_intact(frame: bytes | memoryview) -> bool:
        return wire.is_intact(frame) or zlib.crc32(frame, zlib.crc32(salt)) & mask == 0

    return replace(wire, name=f"{wire.name}-cut-to-{CONTROL_BITS}-bits", is_intact=is_intact)


def proof(size: int, seed: int) -> dict[str, Figure]:
    """Feed ``size`` damaged frames of each format, and of the control."""
    control = with_weak_check(FORMATS["rawimusx"])
    items = [(name, size, seed) for name in (*FORMATS, control.name)]
    return {name: figure for each in spread(_attacked, items) for name, figure in counted(each).items()}


def _attacked(item: tuple[str, int, int]) -> Outcome:
    name, frames, seed = item
    if name in FORMATS:
        return attack(FORMATS[name], frames, seed, FORMATS[name].check_bits)
    return attack(with_weak_check(FORMATS["rawimusx"]), frames, seed, CONTROL_BITS)
