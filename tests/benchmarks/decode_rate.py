"""Print how fast bytes become samples, on one core: `python -m tests.benchmarks.decode_rate`.

Framing, check and samples together, in reads of 64 KiB as from a port or a file. Where the package novatel_edie
(NovAtel's own decoder, C++; `pip install novatel_edie`) is installed, its rate on the same streams stands
beside. For the other formats no decoder is published as a package.
"""

import argparse
import time
from collections.abc import Callable

import numpy as np

from drivers.framing import Decoder
from drivers.wire import FORMATS, WireFormat
from tests.drivers.wire.blocks import a_block

FRAMES = 400_000
BATCH = 20_000  # distinct frames
REPEATS = 3
READ = 65536
THEIR_WRITE = 8192  # its parser's buffer does not take 64 KiB at once
LIMIT_MB_S = 20.0  # for RAWIMUSX
THEIRS = [name for name in FORMATS if name.startswith("rawimu")]


def a_stream(wire: WireFormat, frames: int) -> bytes:
    """Return the bytes of an IMU with large and small counts."""
    batch = a_block(wire, min(BATCH, frames), largest=min(2**17, wire.max_step or 2**17))
    return wire.encode(batch) * (frames // len(batch))


def seconds(work: Callable[[], int], frames: int) -> float:
    """Return the shortest of some runs [s], each of which must find every frame."""
    best = np.inf
    for _ in range(REPEATS):
        start = time.perf_counter()
        found = work()
        best = min(best, time.perf_counter() - start)
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


def their_seconds(name: str, stream: bytes, frames: int) -> float | None:
    """Return how long the field's own decoder takes [s]; None where there is none, or it is not installed."""
    if name not in THEIRS:
        return None
    try:
        return seconds(lambda: decode_by_novatel(stream), frames)
    except ImportError:
        return None


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--frames", type=int, default=FRAMES)
    frames = parser.parse_args().frames // BATCH * BATCH or BATCH
    print(f"{'format':<12}{'MB/s':>8}{'frames/s':>12}{'novatel_edie frames/s':>24}{'ours/theirs':>13}")
    for wire in FORMATS.values():
        stream = a_stream(wire, frames)
        ours = seconds(lambda w=wire, s=stream: decode(w, s), frames)
        theirs = their_seconds(wire.name, stream, frames)
        beside = f"{'-':>24}{'-':>13}" if theirs is None else f"{frames / theirs:>24.0f}{theirs / ours:>12.1f}x"
        print(f"{wire.name:<12}{len(stream) / ours / 1e6:>8.1f}{frames / ours:>12.0f}{beside}", flush=True)


if __name__ == "__main__":
    main()
