"""Feed damaged slcan text to the CAN port: `python -m tests.benchmarks.hostile_slcan --lines 1000000`.

The text goes through python-can's own slcan, the port's records and the joiner. Counted: crashes, frames that
pass identifier, length and CRC-8 and equal none that was sent, samples that equal none, those of them that the
second look at the step does not mark, and intact lines not found. Beside the wrong frames stands what eight bits
let through: 1 in 256 of those whose check was computed and that were damaged. A line may be lost honestly: where
the one before lost its CR, both are one line that is none.
"""

import argparse
import os
import random
import time
from dataclasses import dataclass

import can
import numpy as np

from drivers.can.can_port import CanPort
from drivers.can.checks import CHECKS
from drivers.can.format import can_format
from drivers.can.record import RECORD, unpack
from drivers.can.slcan_line import SlcanLine
from drivers.framing import Decoder
from drivers.simulated.can_faults import text_of
from procedures.records import CountBlock

BATCH, IDS = 600, range(0x1A0, 0x1A6)
ALPHABET = b"0123456789ABCDEFabcdeftTrRzZFV \r\a\n_+-x\x00\xff"
Sent = tuple[int, bytes]


class MemoryLine(SlcanLine):
    """A line whose text is in memory, handed over in pieces."""

    def __init__(self, text: bytes, rng: random.Random) -> None:
        super().__init__(self)  # type: ignore[arg-type]
        self._text, self._next, self._rng = text, 0, rng

    def fill(self, timeout_s: float) -> bool:
        """Hand over the next piece."""
        piece = self._text[self._next : self._next + self._rng.choice((1, 7, 64, 1000, 4096))]
        self._next += len(piece)
        return self.took(piece)

    def write(self, data: bytes, /) -> int:
        """Take what the port asks of its adapter."""
        return len(data)


def damaged(rng: random.Random, line: bytes, other: bytes) -> bytes:
    """Return a line with something done to it."""
    at = rng.randrange(len(line))
    match rng.randrange(10):
        case 0:
            return line[:at] + bytes([rng.choice(ALPHABET)]) + line[at + 1 :]
        case 1:
            return line[:at] + bytes([line[at] ^ 1 << rng.randrange(8)]) + line[at + 1 :]
        case 2:
            return line[:at] + line[at + rng.randrange(1, 5) :]
        case 3:
            return line[:at] + bytes(rng.choices(ALPHABET, k=rng.randrange(1, 5))) + line[at:]
        case 4:
            return line[:at]
        case 5:
            return line[:at] + other[at:]
        case 6:
            return line[:at] + other[rng.randrange(len(other)) :]
        case 7:
            return rng.randbytes(rng.randrange(1, 40))
        case 8:
            return line[:-1] + b"1234\r\a"  # an adapter's time stamp, and BEL: not damaged at all
        case _:
            return b"t%03X8%s\r" % (rng.choice(IDS), rng.randbytes(8).hex().upper().encode())


@dataclass
class Outcome:
    """What came of it."""

    lines: int = 0
    checked: int = 0
    wrong: int = 0
    wrong_samples: int = 0
    believed: int = 0
    samples: int = 0
    intact: int = 0
    lost: int = 0
    crashes: int = 0


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


def attack(lines: int, seed: int) -> Outcome:
    """Feed ``lines`` damaged lines."""
    outcome, rng, numbers = Outcome(), random.Random(seed), np.random.default_rng(seed)
    wire, far, near = can_format(), *os.openpty()
    bus = can.Bus(interface="slcan", channel=os.ttyname(near), sleep_after_open=0.0)
    decoder, first = Decoder(wire), 0
    while outcome.lines < lines:
        block = block_of(BATCH, first, numbers)
        first += BATCH
        sent = [frame for frame in unpack(wire.encode(block)) if frame[0] in IDS]
        texts = [text_of(*frame) for frame in sent]
        pieces, intact = [], set[int]()
        for i, text in enumerate(texts):
            if rng.random() < 0.5:
                pieces.append(damaged(rng, text, texts[i - 1]))
                outcome.lines += 1
            else:
                pieces.append(text)
                intact.add(i)
        records = read(bus, b"".join([*pieces, b"\r"]), rng, outcome)
        got = [frame for frame in unpack(records) if frame[0] in IDS and len(frame[1]) == 8]
        known = set(sent)
        outcome.checked += sum(frame not in known for frame in got)
        outcome.wrong += sum(frame not in known for frame in passes(got))
        outcome.intact += len(intact)
        outcome.lost += len({sent[i] for i in intact} - set(got))
        truth = {tuple(row) for row in np.hstack((block.gyro, block.accel)).tolist()}
        found = decoder.feed(records)
        outcome.samples += len(found)
        rows = np.hstack((found.gyro, found.accel)).tolist()
        wrong = np.array([tuple(row) not in truth for row in rows], dtype=np.bool_)
        outcome.wrong_samples += int(np.count_nonzero(wrong))
        outcome.believed += int(np.count_nonzero(wrong & found.healthy))
    bus.shutdown()
    for descriptor in (far, near):
        os.close(descriptor)
    return outcome


def read(bus: can.BusABC, text: bytes, rng: random.Random, outcome: Outcome) -> bytes:
    """Return the records that the port makes of text."""
    line = MemoryLine(text, rng)
    real, bus.serialPortOrig = bus.serialPortOrig, line  # type: ignore[attr-defined]
    port, records = CanPort(bus, "text", 0.0, line), list[bytes]()
    while line.received < len(text) or line.in_waiting:
        try:
            records.append(port.read(RECORD.itemsize * 100))
        except Exception as error:  # whatever it is, it is a crash
            print(repr(error))
            outcome.crashes += 1
    bus.serialPortOrig = real  # type: ignore[attr-defined]
    return b"".join(records)


def main() -> int:
    """Print what was counted; exit 1 on a crash or more wrong frames than chance allows."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--lines", type=int, default=1_000_000, help="damaged lines")
    parser.add_argument("--seed", type=int, default=1)
    options, began = parser.parse_args(), time.perf_counter()
    got = attack(options.lines, options.seed)
    expected = got.checked / 256
    print(f"damaged lines {got.lines}, crashes {got.crashes}, {time.perf_counter() - began:.0f} s")
    print(f"wrong frames {got.wrong}, expected of 8 bits {expected:.0f} of {got.checked} damaged and checked")
    print(f"samples {got.samples}, of them wrong {got.wrong_samples}, and not marked as unhealthy {got.believed}")
    print(f"intact lines {got.intact}, lost {got.lost}")
    return 0 if got.crashes == 0 and got.wrong <= expected + 5 * np.sqrt(expected) + 1 else 1


if __name__ == "__main__":
    raise SystemExit(main())
