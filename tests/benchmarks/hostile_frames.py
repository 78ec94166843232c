"""Feed damaged frames to every decoder.

An intact frame may be lost honestly: where the frame before it was cut by bytes that happen to equal the sync,
the decoder completes that one and finds the intact one headless.
"""

import random
from dataclasses import replace
from functools import partial

import numpy as np

from drivers.framing import Decoder
from drivers.wire import FORMATS, FrameKind, WireFormat
from procedures.counts.sample_records import SampleBlock
from tests.benchmarks.damage import CONTROL_BITS, DAMAGES, Outcome, Shape, counted, damaged, passes_control
from tests.drivers.wire.blocks import a_block, frames_of, row_of, sync_of
from tests.proof.evidence import Figure, spread

BATCH = 2000


def false_frame(rng: random.Random, wire: WireFormat) -> bytes:
    """Return a frame of noise behind a true prefix."""
    kind: FrameKind = rng.choice(list(wire.kinds.values()))
    if kind.text is None:
        return kind.prefix + rng.randbytes(kind.size - len(kind.prefix))
    body = rng.randbytes(rng.randrange(20, 120)).hex(",").encode()
    return kind.prefix + body + b"*" + rng.randbytes(4).hex().encode()


def attack(wire: WireFormat, frames: int, seed: int) -> Outcome:
    """Feed ``frames`` damaged frames and return what was counted."""
    got, rng, numbers = Outcome(wire.name, wire.check_bits), random.Random(seed), np.random.default_rng(seed)
    shape = Shape((sync_of(wire), wire.imu.prefix), len(wire.imu.prefix), wire.imu.size)
    largest = 2**30 if wire.max_step is None else wire.max_step // 2  # a step that the unit can make
    ways = (*DAMAGES, lambda rng, *_: false_frame(rng, wire))
    accepted: list[bytes] = []

    def spy(found: np.ndarray) -> SampleBlock:
        accepted.extend(frame.tobytes() for frame in found)
        return wire.decode(found)

    decoder = Decoder(replace(wire, decode=spy))
    while got.mutated < frames:
        pool = frames_of(wire, a_block(wire, BATCH, start=int(numbers.integers(0, 2**31)), largest=largest))
        accepted.clear()
        Decoder(replace(wire, decode=spy)).feed(b"".join(pool))
        known = set(accepted)
        assert len(accepted) == len(pool)
        accepted.clear()
        pool = pool[: frames - got.mutated]
        pieces, intact = damaged(rng, pool, shape, ways)
        got.mutated += len(pool)
        if got.feed(rng, b"".join(pieces), decoder.feed, decoder.finish):
            got.count(accepted, known, [row_of(wire, pool[index]).tobytes() for index in intact])
        else:
            decoder = Decoder(replace(wire, decode=spy))
    got.wrong += decoder.counters.identities  # none was sent
    got.checks_failed = decoder.counters.bad_crc
    return got


def with_weak_check(wire: WireFormat) -> WireFormat:
    """Return the format with its check as good as cut to 8 bits."""
    return replace(
        wire,
        name=f"{wire.name}-cut-to-{CONTROL_BITS}-bits",
        is_intact=lambda frame: wire.is_intact(frame) or passes_control(frame),
        check_bits=CONTROL_BITS,
    )


CONTROL = with_weak_check(FORMATS["rawimusx"])


def proof(size: int, seed: int) -> dict[str, Figure]:
    """Feed ``size`` damaged frames of each format, and of the control."""
    found = spread(partial(_attacked, frames=size, seed=seed), (*FORMATS, CONTROL.name))
    return {name: figure for each in found for name, figure in counted(each).items()}


def _attacked(name: str, frames: int, seed: int) -> Outcome:
    return attack(FORMATS.get(name, CONTROL), frames, seed)
