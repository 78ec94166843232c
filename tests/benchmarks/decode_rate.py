"""Print how fast bytes become samples, on one core: `python -m tests.benchmarks.decode_rate`.

Framing, check and samples together, in reads of 64 KiB as from a port or a file. By processor time, the shortest
of some runs in turn, so that what else the machine does counts little. Where the package novatel_edie (NovAtel's
own decoder, C++; `pip install novatel_edie`) is installed, its rate on the same streams stands beside.
For the other formats no decoder is published as a package.
"""

import argparse
import time
from collections.abc import Callable, Sequence
from functools import partial
from importlib.util import find_spec

import numpy as np

from drivers.framing import Decoder
from drivers.wire import FORMATS, WireFormat
from tests.drivers.wire.blocks import a_block

FRAMES = 40_000
BATCH = 20_000  # distinct frames
REPEATS = 15
READ = 65536
THEIR_WRITE = 8192  # its parser's buffer does not take 64 KiB at once
LIMIT_MB_S = 20.0  # for RAWIMUSX
THEIRS = [name for name in FORMATS if name.startswith("rawimu")]


def a_stream(wire: WireFormat, frames: int) -> bytes:
    """Return the bytes of an IMU with large and small counts."""
    batch = a_block(wire, min(BATCH, frames), largest=min(2**17, wire.max_step or 2**17))
    return wire.encode(batch) * (frames // len(batch))


def seconds(works: Sequence[Callable[[], int]], frames: int) -> list[float]:
    """Return the shortest of some runs of each [s of processor time]; every one must find every frame."""
    best = [np.inf] * len(works)
    for _ in range(REPEATS):
        for i, work in enumerate(works):
            start = time.process_time()
            found = work()
            best[i] = min(best[i], time.process_time() - start)
            assert found == frames, f"{found} of {frames} frames"
    return best


def decode(wire: WireFormat, stream: bytes) -> int:
    """Decode the stream in reads; return the number of frames."""
    decoder = Decoder(wire)
    return sum(len(decoder.feed(stream[at : at + READ])) for at in range(0, len(stream), READ))


def decode_by_novatel(stream: bytes) -> int:
    """Decode the stream with novatel_edie; return the number of raw IMU messages."""
    from novatel_edie.oem import Parser

    parser, found = Parser(), 0
    for at in range(0, len(stream), THEIR_WRITE):
        parser.write(stream[at : at + THEIR_WRITE])
        found += sum(type(message).__name__.startswith("RAWIMU") for message in parser)
    return found


def is_theirs(name: str) -> bool:
    """Say whether the field's own decoder reads a format, and is installed."""
    return name in THEIRS and find_spec("novatel_edie") is not None


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--frames", type=int, default=FRAMES)
    frames = parser.parse_args().frames // BATCH * BATCH or BATCH
    print(f"{'format':<12}{'MB/s':>8}{'frames/s':>12}{'novatel_edie frames/s':>24}{'ours/theirs':>13}")
    for wire in FORMATS.values():
        stream = a_stream(wire, frames)
        works = [partial(decode, wire, stream)]
        works += [partial(decode_by_novatel, stream)] if is_theirs(wire.name) else []
        ours, *theirs = seconds(works, frames)
        beside = f"{frames / theirs[0]:>24.0f}{theirs[0] / ours:>12.2f}x" if theirs else f"{'-':>24}{'-':>13}"
        print(f"{wire.name:<12}{len(stream) / ours / 1e6:>8.1f}{frames / ours:>12.0f}{beside}", flush=True)


if __name__ == "__main__":
    main()
