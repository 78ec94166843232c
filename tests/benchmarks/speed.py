"""How fast bytes become samples and samples attitudes, each next to a peer in the same process on the same data.

By processor time, the shortest of some runs in turn, so that what else the machine does counts little. For the
serial formats no decoder is published as a package: bytes a second stand there.
"""

import random
import time
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
from pymavlink.dialects.v20 import all as dialect
from vqf import VQF

from drivers.can.can_format import OWN_DBC, can_format
from drivers.can.dbc_signals import load_dbc
from drivers.can.frame_record import unpack
from drivers.framing import Decoder
from drivers.mavlink.frames import MavlinkFramer, fields
from drivers.wire import FORMATS, WireFormat
from procedures.attitude.complementary_filter import ComplementaryFilter
from procedures.attitude.kalman.kalman_filter import AttitudeKalmanFilter
from procedures.attitude.kalman.kalman_settings import UNAIDED_SETTINGS
from tests.benchmarks.hostile_mavlink import a_sender, some_frames
from tests.benchmarks.hostile_slcan import block_of
from tests.drivers.simulated.flight import paper_flight
from tests.drivers.wire.blocks import a_block
from tests.proof.evidence import Figure

REPEATS, READ = 7, 65536
BATCH = 20_000  # distinct frames


def seconds(works: Sequence[Callable[[], int]], expected: int | None) -> list[float]:
    """Return the shortest of some runs of each [s of processor time]; every one must find all that is expected."""
    best = [np.inf] * len(works)
    for _ in range(REPEATS):
        for i, work in enumerate(works):
            start = time.process_time()
            found = work()
            best[i] = min(best[i], time.process_time() - start)
            assert expected is None or found == expected, f"{found} of {expected}"
    return best


def decode(wire: WireFormat, stream: bytes) -> int:
    """Decode the stream in reads; return the number of samples."""
    decoder = Decoder(wire)
    return sum(len(decoder.feed(stream[at : at + READ])) for at in range(0, len(stream), READ))


def wires(frames: int) -> dict[str, Figure]:
    """Return the rate of each serial format."""
    result = dict[str, Figure]()
    for name, wire in FORMATS.items():
        batch = a_block(wire, min(BATCH, frames), largest=min(2**17, wire.max_step or 2**17))
        stream = wire.encode(batch) * (frames // len(batch))
        (ours,) = seconds([partial(decode, wire, stream)], frames)
        result[f"{name}: bytes to samples"] = Figure(len(stream) / ours / 1e6, "MB/s")
    return result


def can(frames: int, seed: int) -> dict[str, Figure]:
    """Return the rate of frames to checked, joined samples next to cantools, which only decodes."""
    wire, database = can_format(), load_dbc(OWN_DBC)
    stream = wire.encode(block_of(frames, 0, np.random.default_rng(seed)))
    every = unpack(stream)

    def theirs() -> int:
        return frames * (sum(bool(database.decode_message(*each)) for each in every) == len(every))

    ours, cantools = seconds([partial(decode, wire, stream), theirs], frames)
    return {"CAN: frames a second": Figure(cantools / ours, "times cantools", at_least=0.8)}


def mavlink(frames: int, seed: int) -> dict[str, Figure]:
    """Return the rate of MAVLink messages next to pymavlink, in reads of 4 KiB."""
    stream = b"".join(some_frames(random.Random(seed), a_sender(), frames))
    reads = [stream[at : at + 4096] for at in range(0, len(stream), 4096)]

    def ours() -> int:
        framer = MavlinkFramer()
        return sum(len([fields(frame) for frame in framer.feed(read)]) for read in reads)

    def theirs() -> int:
        mav = dialect.MAVLink(None)
        return sum(len(mav.parse_buffer(read) or ()) for read in reads)

    station, pymavlink = seconds([ours, theirs], frames)
    return {"MAVLink: messages a second": Figure(pymavlink / station, "times pymavlink", at_least=0.8)}


def attitudes(seed: int) -> dict[str, Figure]:
    """Return the samples a second of the attitude filters, next to vqf's."""
    log = paper_flight(seed, 1750.0)
    works: list[Callable[[], object]] = [
        lambda: ComplementaryFilter().run(log),
        lambda: AttitudeKalmanFilter("none", UNAIDED_SETTINGS).run(log),
        lambda: VQF(log.nominal).updateBatch(log.omega_b, log.f_b),
    ]
    for work in works:
        work()
    filter_, kalman, vqf = seconds(works, None)
    return {
        "complementary filter: samples a second": Figure(vqf / filter_, "times vqf"),
        "Kalman filter: samples a second": Figure(vqf / kalman, "times vqf"),
    }


def proof(size: int, seed: int) -> dict[str, Figure]:
    """Return all of it, of ``size`` frames each."""
    whole = max(size // BATCH, 1) * min(size, BATCH)
    return {**can(size, seed), **mavlink(size, seed), **attitudes(seed), **wires(whole)}
