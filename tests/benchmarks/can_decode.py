"""Print how fast CAN frames become counts beside cantools: `python -m tests.benchmarks.can_decode`.

Ours: records to checked, joined samples, in reads of 64 KiB. Theirs: `decode_message` of the same frames by
cantools alone, no check, no joining. Same process, same frames, best of three.
"""

import time
from collections.abc import Callable

import numpy as np

from drivers.can.can_format import OWN_DBC, can_format
from drivers.can.dbc_file import load_dbc
from drivers.can.frame_record import unpack
from drivers.framing import Decoder
from procedures.counts.sample_records import CountBlock

SAMPLES, REPEATS, READ, LEAST = 50_000, 3, 65536, 0.8


def a_block(n: int) -> CountBlock:
    """Return n samples of 500 Hz."""
    rng, counter = np.random.default_rng(1), np.arange(n)
    return CountBlock(
        counter=counter,
        device_time=(counter + 1) * 0.002,
        gyro=rng.integers(-(2**18), 2**18, (n, 3)),
        accel=rng.integers(-100, 100, (n, 3)),
        temperature=np.full(n, 25.0),
        status=np.zeros(n, np.int64),
        healthy=np.ones(n, np.bool_),
    )


def best(work: Callable[[], int], expected: int) -> float:
    """Return the shortest of some runs [s], each of which must find everything."""
    times = []
    for _ in range(REPEATS):
        start = time.perf_counter()
        assert work() == expected
        times.append(time.perf_counter() - start)
    return min(times)


def main() -> int:
    """Print the rates; exit 1 under 0.8 of the bare library."""
    wire, database = can_format(), load_dbc(OWN_DBC)
    stream = wire.encode(a_block(SAMPLES))
    frames = unpack(stream)

    def ours() -> int:
        decoder = Decoder(wire)
        return sum(len(decoder.feed(stream[at : at + READ])) for at in range(0, len(stream), READ))

    def theirs() -> int:
        return sum(bool(database.decode_message(identifier, data)) for identifier, data in frames)

    rates = len(frames) / best(ours, SAMPLES), len(frames) / best(theirs, len(frames))
    for name, rate in zip(("frames to samples", "cantools decode_message"), rates, strict=True):
        print(f"{name:<28}{rate:>12.0f} frames/s")
    print(f"ours is {rates[0] / rates[1]:.1f} x, required {LEAST}")
    return 0 if rates[0] >= LEAST * rates[1] else 1


if __name__ == "__main__":
    raise SystemExit(main())
