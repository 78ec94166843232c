"""Feed damaged parts of MJPEG to the camera's decoder.

As `hostile_frames`: every damaged part is followed by an intact one with chance 1/8. Counted: crashes, accepted
images whose length is no image's (cut, spliced, with bytes lost or added), and intact ones not found. JPEG has no
check: an image of the right length may be altered within, and is counted beside. Without Content-Length, or any
header, only markers are left to say what is whole: there images of wrong length must come out, or this proof could
not see any.
"""

import random
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np

from drivers.camera import CameraDecoder
from drivers.camera.decoder import part
from procedures.optional_libraries import opencv
from tests.benchmarks.damage import DAMAGES, Shape, cuts, damaged
from tests.proof.evidence import Figure, zero

BATCH, IMAGES = 100, 200
SHAPE = Shape((b"\xff\xd8\xff", b"--boundarydonotcross\r\n", b"\r\n\r\n"), 20, 1500)
ROWS: dict[str, Callable[[bytes], bytes]] = {
    "with Content-Length": lambda jpeg: part(jpeg, 12.5),
    "without it": lambda jpeg: part(jpeg, 12.5).replace(b"Content-Length", b"X-Nothing"),
    "without headers": lambda jpeg: jpeg,
}


@dataclass
class CameraOutcome:
    """What came of a run."""

    damaged: int = 0
    intact: int = 0
    accepted: int = 0
    altered: int = 0
    wrong: int = 0
    lost: int = 0
    crashes: int = 0


@cache
def some_jpegs(seed: int) -> tuple[bytes, ...]:
    """Return small images, of which each is another and of another length."""
    cv, rng, found = opencv(), np.random.default_rng(seed), dict[int, bytes]()
    while len(found) < IMAGES:
        image = cv.GaussianBlur(rng.integers(0, 255, (32, 48), np.uint8), (3, 3), rng.uniform(0.3, 1.5))
        jpeg = bytes(cv.imencode(".jpg", image, [cv.IMWRITE_JPEG_QUALITY, int(rng.integers(60, 100))])[1])
        found[len(jpeg)] = jpeg
    return tuple(found.values())


def attack(parts: int, seed: int, as_sent: Callable[[bytes], bytes]) -> CameraOutcome:
    """Feed ``parts`` damaged parts to one decoder and return what was counted."""
    outcome, rng, decoder = CameraOutcome(), random.Random(seed), CameraDecoder()
    known = {jpeg: number for number, jpeg in enumerate(some_jpegs(seed))}
    lengths = {len(jpeg) for jpeg in known}
    while outcome.damaged < parts:
        chosen = rng.sample(some_jpegs(seed), min(BATCH, parts - outcome.damaged))
        pieces, intact = damaged(rng, [as_sent(jpeg) for jpeg in chosen], SHAPE, DAMAGES)
        outcome.damaged += len(chosen)
        got = list[bytes]()
        try:
            for data in cuts(rng, b"".join(pieces) + as_sent(chosen[0]) * 45):  # 64 kB: a segment's longest lead
                got += [image.jpeg for image in decoder.feed(data, 0)]
        except Exception as error:  # whatever it is, it is a crash
            outcome.crashes += 1
            print(f"camera: {error!r}", file=sys.stderr)
        strangers = [jpeg for jpeg in got if jpeg not in known]
        outcome.accepted += len(got)
        outcome.altered += sum(len(jpeg) in lengths for jpeg in strangers)
        outcome.wrong += sum(len(jpeg) not in lengths for jpeg in strangers)
        outcome.intact += len(intact)
        outcome.lost += sum(chosen[index] not in got for index in intact)
    return outcome


def proof(size: int, seed: int) -> dict[str, Figure]:
    """Feed ``size`` damaged parts in each of three forms."""
    result = dict[str, Figure]()
    for name, as_sent in ROWS.items():
        got, most = (
            attack(size, seed, as_sent),
            size / 10_000,
        )  # header and image of one part damaged: no length left
        result[f"{name}: crashes"] = zero(got.crashes)
        is_long = name == "with Content-Length"
        wrong = Figure(got.wrong, at_most=most) if is_long else Figure(got.wrong, at_least=most)
        result[f"{name}: images of a wrong length"] = wrong
        result[f"{name}: images altered within"] = Figure(got.altered, of=got.accepted)
        result[f"{name}: intact images not found"] = Figure(got.lost, of=got.intact)
    return result
