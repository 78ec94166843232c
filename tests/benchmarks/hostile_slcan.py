"""Feed damaged slcan text to the CAN port.

The text goes through python-can's own slcan, the port's records and the joiner. Wrong are frames that pass
identifier, length and CRC-8 and equal none that was sent; counted too are samples that equal none, and those of
them that the second look at the step does not mark. A line may be lost honestly: where the one before lost its CR,
both are one line that is none.
"""

import os
import random
from collections.abc import Iterator
from dataclasses import dataclass

import can
import numpy as np
import serial

from drivers.can.can_format import can_format
from drivers.can.can_port import CanPort, SlcanLine
from drivers.can.frame_record import RECORD, unpack
from drivers.can.mapping_file import CHECKS
from drivers.framing import Decoder
from drivers.simulated.corrupted_frames import text_of
from procedures.counts.sample_records import CountBlock, SampleBlock
from tests.benchmarks.damage import DAMAGES, Mutation, Outcome, Shape, counted, cuts
from tests.proof.evidence import Figure

BATCH, IDS = 600, range(0x1A0, 0x1A6)
BITS = 8  # of the check in a frame
SHAPE = Shape((b"t", b"\r"), len("t1A08"), len("t1A08") + 16 + 1)
ALPHABET = b"0123456789ABCDEFabcdeftTrRzZFV \r\a\n_+-x\x00\xff"
Sent = tuple[int, bytes]


class MemoryLine(SlcanLine):
    """A line whose text is in memory, handed over in pieces."""

    def __init__(self, line: serial.Serial, pieces: Iterator[bytes]) -> None:
        super().__init__(line)
        self._pieces = pieces
        self.is_over = False

    def fill(self, timeout_s: float) -> bool:
        """Hand over the next piece."""
        piece = next(self._pieces, b"")
        self.is_over = not piece
        return self.took(piece)


def _other_character(rng: random.Random, line: bytes, _: bytes, __: Shape) -> bytes:
    at = rng.randrange(len(line))
    return line[:at] + bytes(rng.choices(ALPHABET, k=rng.randrange(1, 5))) + line[at + rng.randrange(2) :]


def _stamped(_: random.Random, line: bytes, __: bytes, ___: Shape) -> bytes:
    return line[:-1] + b"1234\r\a"  # an adapter's time stamp, and BEL: not damaged at all


def _made_up(rng: random.Random, _: bytes, __: bytes, ___: Shape) -> bytes:
    return b"t%03X8%s\r" % (rng.choice(IDS), rng.randbytes(8).hex().upper().encode())


# A burst of up to eight bits always fails the check; made-up lines pass as often as chance has it.
WAYS: tuple[Mutation, ...] = (*DAMAGES, _other_character, _stamped, _made_up, _made_up, _made_up)


@dataclass
class LinesOutcome(Outcome):
    """What came of it; of samples, ``believed`` are those that are wrong and not marked as unhealthy."""

    samples: int = 0
    wrong_samples: int = 0
    believed: int = 0


def block_of(n: int, first: int, rng: np.random.Generator) -> CountBlock:
    """Return n samples, no two alike."""
    counter = first + np.arange(n)
    return CountBlock(
        counter, (counter + 1) * 0.002, rng.integers(-(2**17), 2**17, (n, 3)), rng.integers(-300, 300, (n, 3)),
        np.full(n, 25.0), np.zeros(n, np.int64), np.ones(n, np.bool_),
    )  # fmt: skip


def passes(frames: list[Sent]) -> list[Sent]:
    """Return the frames of our identifiers and length whose CRC-8 is right."""
    if not frames:
        return []
    ids = np.array([identifier for identifier, _ in frames], np.uint32)
    data = np.frombuffer(b"".join(payload for _, payload in frames), np.uint8).reshape(-1, 8)
    good = CHECKS["crc8-autosar-id"](ids, data[:, :7]) == data[:, 7]
    return [frame for frame, is_good in zip(frames, good, strict=True) if is_good]


def attack(lines: int, seed: int) -> LinesOutcome:
    """Feed ``lines`` damaged lines, and as many intact ones between them."""
    outcome, rng, numbers = LinesOutcome("slcan, CRC-8", BITS), random.Random(seed), np.random.default_rng(seed)
    wire, far, near = can_format(), *os.openpty()
    bus = can.Bus(interface="slcan", channel=os.ttyname(near), sleep_after_open=0.0)
    decoder, first = Decoder(wire), 0
    while outcome.mutated < lines:
        block = block_of(BATCH, first, numbers)
        first += BATCH
        sent = [frame for frame in unpack(wire.encode(block)) if frame[0] in IDS]
        texts = [text_of(*frame) for frame in sent]
        pieces, intact = list[bytes](), list[Sent]()
        for i, text in enumerate(texts):
            if rng.random() < 0.5:
                pieces.append(rng.choice(WAYS)(rng, text, texts[i - 1], SHAPE))
                outcome.mutated += 1
            else:
                pieces.append(text)
                intact.append(sent[i])
        records = read(bus, b"".join([*pieces, b"\r"]), rng, outcome)
        got = [frame for frame in unpack(records) if frame[0] in IDS and len(frame[1]) == 8]
        accepted = passes(got)
        outcome.checks_failed += len(got) - len(accepted)
        outcome.count(accepted, set(sent), intact)
        judge(decoder.feed(records), block, outcome)
    bus.shutdown()
    for descriptor in (far, near):
        os.close(descriptor)
    return outcome


def judge(found: SampleBlock, block: CountBlock, outcome: LinesOutcome) -> None:
    """Compare samples with those that were sent."""
    truth = {tuple(values) for values in np.hstack((block.gyro, block.accel)).tolist()}
    rows = np.hstack((found.gyro, found.accel)).tolist()
    wrong = np.array([tuple(values) not in truth for values in rows], dtype=np.bool_)
    outcome.samples += len(found)
    outcome.wrong_samples += int(np.count_nonzero(wrong))
    outcome.believed += int(np.count_nonzero(wrong & found.healthy))


def read(bus: can.BusABC, text: bytes, rng: random.Random, outcome: Outcome) -> bytes:
    """Return the records that the port makes of text."""
    real = bus.serialPortOrig
    line = bus.serialPortOrig = MemoryLine(real, iter(cuts(rng, text)))
    port, records = CanPort(bus, "text", 0.0, line), list[bytes]()
    while not line.is_over or line.in_waiting:
        try:
            records.append(port.read(RECORD.itemsize * 100))
        except Exception as error:  # whatever it is, it is a crash
            print(repr(error))
            outcome.crashes += 1
    bus.serialPortOrig = real
    return b"".join(records)


def proof(size: int, seed: int) -> dict[str, Figure]:
    """Feed ``size`` damaged lines, and as many intact ones between them."""
    got = attack(size, seed)
    return {
        **counted(got),
        "slcan, CRC-8: wrong samples": Figure(got.wrong_samples, of=got.samples),
        "slcan, CRC-8: wrong samples not marked unhealthy": Figure(got.believed, of=got.samples),
    }
