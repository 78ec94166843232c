"""Print how fast MAVLink is decoded beside bare pymavlink: `python -m tests.benchmarks.mavlink_rate`.

Both read the same stream of autopilot messages in reads of 4 KiB, one core, in one run. The second line has
garbage between the frames, where pymavlink loses some; the third goes on to records in SI, which it does not make.
"""

import random
import time
from collections.abc import Callable

from pymavlink.dialects.v20 import all as dialect

from drivers.mavlink.decoder import MavlinkDecoder
from drivers.mavlink.mavlink_framing import MavlinkFramer
from drivers.mavlink.messages import fields
from tests.benchmarks.hostile_mavlink import a_sender, some_frames

FRAMES, REPEATS, READ = 40_000, 5, 4096
LIMIT = 0.8


def ours(stream: bytes) -> int:
    """Decode to fields; return the number of good frames."""
    framer, found = MavlinkFramer(), 0
    for at in range(0, len(stream), READ):
        found += len([fields(frame) for frame in framer.feed(stream[at : at + READ])])
    return found


def to_records(stream: bytes) -> int:
    """Decode to records in SI; return the number of good frames."""
    decoder = MavlinkDecoder()
    for at in range(0, len(stream), READ):
        decoder.feed(stream[at : at + READ], at)
    return decoder.framer.counters.frames


def theirs(stream: bytes) -> int:
    """Decode with pymavlink alone; return the number of good messages."""
    mav, found = dialect.MAVLink(None), 0
    mav.robust_parsing = True
    for at in range(0, len(stream), READ):
        found += sum(one.get_type() != "BAD_DATA" for one in mav.parse_buffer(stream[at : at + READ]) or ())
    return found


def once(work: Callable[[bytes], int], stream: bytes) -> tuple[float, int]:
    """Return how long a run took [s] and what it found."""
    start = time.perf_counter()
    found = work(stream)
    return time.perf_counter() - start, found


def main() -> int:
    """Print the table; exit 1 below 0.8 of the bare library."""
    rng = random.Random(1)
    frames = some_frames(rng, a_sender(), FRAMES)
    clean = b"".join(frames)
    noisy = b"".join(frame + rng.randbytes(rng.randrange(12)) for frame in frames)
    good = True
    print(f"{'stream':<18}{'ours, frames/s':>16}{'pymavlink':>12}{'ratio':>8}{'ours found':>12}{'pymavlink':>12}")
    runs = (("clean", ours, clean), ("noisy", ours, noisy), ("clean, to records", to_records, clean))
    for name, work, stream in runs:
        pairs = [
            (once(work, stream), once(theirs, stream)) for _ in range(REPEATS)
        ]  # in turn: the machine is shared
        a, b = (min(pair[i][0] for pair in pairs) for i in (0, 1))
        (_, found_a), (_, found_b) = pairs[0]
        print(f"{name:<18}{FRAMES / a:>16.0f}{FRAMES / b:>12.0f}{b / a:>8.2f}{found_a:>12}{found_b:>12}")
        good &= b / a >= LIMIT or work is to_records
    return 0 if good else 1


if __name__ == "__main__":
    raise SystemExit(main())
