"""How a stream of frames is damaged, and what came of it: shared by the proofs with damaged bytes.

Every damaged frame is followed by an intact one with chance 1/8. Counted are crashes, accepted frames that equal
none that was sent, and intact frames not found. Next to the wrong ones stands what the width of the check allows:
2^-bits per frame whose check was computed and failed. A control has its check cut to 8 bits: there wrong frames
must come out at about the rate expected, or the proof could not see any.
"""

import random
import sys
import zlib
from collections.abc import Callable, Hashable, Sequence, Set
from dataclasses import dataclass

import numpy as np

from tests.proof.evidence import Figure, zero

CONTROL_BITS = 8  # of the check in a control row, in which wrong frames must come out


@dataclass(frozen=True, slots=True)
class Shape:
    """What damage aims at: bytes frames begin with, how many stand before a body, about how many a frame has."""

    starts: tuple[bytes, ...]
    head: int
    size: int


Mutation = Callable[[random.Random, bytes, bytes, Shape], bytes]


def _flip_bits(rng: random.Random, frame: bytes, _: bytes, __: Shape) -> bytes:
    damaged = bytearray(frame)
    for _ in range(rng.choice((1, 1, 2, 3, 4, 5, 8, 16, 40))):
        damaged[rng.randrange(len(frame))] ^= 1 << rng.randrange(8)
    return bytes(damaged)


def _overwrite(rng: random.Random, frame: bytes, _: bytes, shape: Shape) -> bytes:
    start = rng.randrange(shape.head, len(frame))
    end = min(start + rng.randrange(1, 12), len(frame))
    return frame[:start] + rng.randbytes(end - start) + frame[end:]


def _drop(rng: random.Random, frame: bytes, _: bytes, __: Shape) -> bytes:
    start = rng.randrange(len(frame))
    return frame[:start] + frame[start + rng.randrange(1, 6) :]


def _insert(rng: random.Random, frame: bytes, _: bytes, shape: Shape) -> bytes:
    start = rng.randrange(len(frame))
    added = rng.choice((rng.randbytes(rng.randrange(1, 6)), shape.starts[0]))
    return frame[:start] + added + frame[start:]


def _truncate(rng: random.Random, frame: bytes, _: bytes, __: Shape) -> bytes:
    return frame[: rng.randrange(len(frame))]


def _splice(rng: random.Random, frame: bytes, other: bytes, _: Shape) -> bytes:
    cut = rng.randrange(len(frame))
    return frame[:cut] + other[cut:]


def _shifted_splice(rng: random.Random, frame: bytes, other: bytes, _: Shape) -> bytes:
    return frame[: rng.randrange(len(frame))] + other[rng.randrange(len(other)) :]


def _garbage(rng: random.Random, _: bytes, __: bytes, shape: Shape) -> bytes:
    return rng.choice((b"", *shape.starts)) + rng.randbytes(rng.randrange(1, 2 * shape.size))


DAMAGES: tuple[Mutation, ...] = (
    _flip_bits, _overwrite, _drop, _insert, _truncate, _splice, _shifted_splice, _garbage,
)  # fmt: skip


def damaged(
    rng: random.Random, pool: Sequence[bytes], shape: Shape, ways: Sequence[Mutation]
) -> tuple[list[bytes], list[int]]:
    """Return the pieces of a stream, damaged frames and an intact one behind one in eight; which those are."""
    pieces, intact = list[bytes](), list[int]()
    for index, frame in enumerate(pool):
        pieces.append(rng.choice(ways)(rng, frame, pool[index - 1], shape))
        if rng.random() < 0.125:
            intact.append(index - 1)
            pieces.append(pool[index - 1])
    return pieces, intact


def cuts(rng: random.Random, stream: bytes) -> list[bytes]:
    """Return a stream as reads of all sizes give it."""
    parts, at = list[bytes](), 0
    while at < len(stream):
        parts.append(stream[at : at + rng.choice((1, 7, 64, 1000, 4096, 65536))])
        at += len(parts[-1])
    return parts


@dataclass
class Outcome:
    """What came of a run against a check of ``bits``."""

    name: str
    bits: int
    mutated: int = 0
    intact: int = 0
    checks_failed: int = 0
    accepted: int = 0
    wrong: int = 0
    lost: int = 0
    crashes: int = 0

    @property
    def expected(self) -> float:
        """Wrong frames that a check of this width lets through by chance."""
        return (self.checks_failed + self.wrong) / 2.0**self.bits

    def feed(
        self, rng: random.Random, stream: bytes, take: Callable[[bytes], object], end: Callable[[], object] = list
    ) -> bool:
        """Give a stream in reads of all sizes, and end it; return whether it was taken without a crash."""
        try:
            for part in cuts(rng, stream):
                take(part)
            end()
        except Exception as error:  # whatever it is, it is a crash
            self.crashes += 1
            print(f"{self.name}: {error!r}", file=sys.stderr)
            return False
        return True

    def count(self, accepted: Sequence[Hashable], sent: Set[Hashable], intact: Sequence[Hashable]) -> None:
        """Count what was accepted, of it what nobody sent, and what is lost of the intact ones."""
        self.accepted += len(accepted)
        self.wrong += sum(frame not in sent for frame in accepted)
        self.intact += len(intact)
        got = set(accepted)
        self.lost += sum(frame not in got for frame in intact)


def passes_control(frame: bytes | memoryview) -> bool:
    """Say whether a control lets a frame through: by a hash of it, in which any error shows."""
    return zlib.crc32(frame, zlib.crc32(b"control")) % 2**CONTROL_BITS == 0


def counted(got: Outcome) -> dict[str, Figure]:
    """Return what came of a run: crashes, and no more wrong frames than its check lets through by chance."""
    allowed = 2 * got.expected + (5 * np.sqrt(got.expected) + 1 if got.expected > 1e-2 else 0)
    result = {
        f"{got.name}: damaged": Figure(got.mutated),
        f"{got.name}: crashes": zero(got.crashes),
        f"{got.name}: wrong frames accepted": Figure(got.wrong, at_most=round(allowed, 1)),
    }
    if got.bits == CONTROL_BITS:  # a control: wrong frames must come out, or this could see none
        seen = Figure(got.wrong, at_least=round(got.expected / 2, 1), at_most=round(allowed, 1))
        result[f"{got.name}: wrong frames accepted"] = seen
    return result
