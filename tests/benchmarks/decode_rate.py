"""Print how fast bytes become counts, on one core: `python -m tests.benchmarks.decode_rate`.

Framing, CRC and counts together, in reads of 64 KiB as from a port or a file. Where the package
novatel_edie (NovAtel's own decoder, C++) is installed, its rate on the same RAWIMUSX stream stands beside.
"""

import time
from collections.abc import Callable

import numpy as np

from drivers.framing import Decoder
from drivers.wire import FORMATS, WireFormat
from procedures.records import CountBlock

FRAMES = 400_000
REPEATS = 3
READ = 65536
THEIR_WRITE = 8192  # its parser's buffer does not take 64 KiB at once
LIMIT_MB_S = 20.0


def a_block(n: int) -> CountBlock:
    """Return n samples of an IMU at rest with large and small counts."""
    rng = np.random.default_rng(1)
    return CountBlock(
        counter=np.arange(n),
        device_time=1e6 + np.arange(n) * 0.0025,
        gyro=rng.integers(-(2**20), 2**20, (n, 3)),
        accel=rng.integers(-100, 100, (n, 3)),
        temperature=np.full(n, 25.0),
        status=np.zeros(n, np.int64),
        healthy=np.ones(n, np.bool_),
    )


def seconds(work: Callable[[], int]) -> float:
    """Return the shortest of some runs [s], each of which must find every frame."""
    best = np.inf
    for _ in range(REPEATS):
        start = time.perf_counter()
        found = work()
        best = min(best, time.perf_counter() - start)
        assert found == FRAMES, f"{found} of {FRAMES} frames"
    return best


def decode(wire: WireFormat, stream: bytes) -> int:
    """Decode the stream in reads; return the number of frames."""
    decoder = Decoder(wire)
    return sum(len(decoder.feed(stream[at : at + READ])) for at in range(0, len(stream), READ))


def decode_by_novatel(stream: bytes) -> int:
    """Decode the stream with novatel_edie; return the number of RAWIMUSX messages."""
    from novatel_edie.oem import Parser

    parser, found = Parser(), 0
    for at in range(0, len(stream), THEIR_WRITE):
        parser.write(stream[at : at + THEIR_WRITE])
        found += sum(type(message).__name__.startswith("RAWIMUSX") for message in parser)
    return found


def main() -> None:
    """Print the table."""
    print(f"{'format':<28}{'MB/s':>8}{'frames/s':>12}   required {LIMIT_MB_S:g} MB/s")
    rates = {}
    for wire in FORMATS.values():
        stream = wire.encode(a_block(FRAMES))
        rates[wire.name] = len(stream) / seconds(lambda w=wire, s=stream: decode(w, s)) / 1e6
        print(f"{wire.name:<28}{rates[wire.name]:>8.1f}{rates[wire.name] * 1e6 / wire.imu.size:>12.0f}")
    stream = FORMATS["rawimusx"].encode(a_block(FRAMES))
    try:
        theirs = len(stream) / seconds(lambda: decode_by_novatel(stream)) / 1e6
    except ImportError:
        print("novatel_edie is not installed: no comparison")
        return
    name = "rawimusx by novatel_edie"
    print(f"{name:<28}{theirs:>8.1f}{theirs * 1e6 / 56:>12.0f}   ours is {rates['rawimusx'] / theirs:.1f} x")


if __name__ == "__main__":
    main()
