"""Feed damaged parts of MJPEG to the camera's decoder.

JPEG has no check: wrong are accepted images whose length is no image's (cut, spliced, with bytes lost or added);
one of the right length may be altered within, and is counted apart. Without Content-Length, or any header, only
markers are left to say what is whole: there images of wrong length must come out, or this proof could see none.
"""

import random
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np

from drivers.camera import CameraDecoder
from drivers.camera.decoder import part
from procedures.optional_libraries import opencv
from tests.benchmarks.damage import DAMAGES, Outcome, Shape, damaged
from tests.proof.evidence import Figure, zero

BATCH, IMAGES = 100, 200
SHAPE = Shape((b"\xff\xd8\xff", b"--boundarydonotcross\r\n", b"\r\n\r\n"), 20, 1500)
ROWS: dict[str, Callable[[bytes], bytes]] = {
    "with Content-Length": lambda jpeg: part(jpeg, 12.5),
    "without it": lambda jpeg: part(jpeg, 12.5).replace(b"Content-Length", b"X-Nothing"),
    "without headers": lambda jpeg: jpeg,
}


@dataclass
class CameraOutcome(Outcome):
    """What came of a run; ``altered`` have the length of an image, ``wrong`` have not."""

    altered: int = 0


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
    got, rng, decoder = CameraOutcome("camera", bits=0), random.Random(seed), CameraDecoder()
    jpegs = some_jpegs(seed)
    known, lengths = set(jpegs), {len(jpeg) for jpeg in jpegs}
    while got.mutated < parts:
        chosen = rng.sample(jpegs, min(BATCH, parts - got.mutated))
        pieces, intact = damaged(rng, [as_sent(jpeg) for jpeg in chosen], SHAPE, DAMAGES)
        got.mutated += len(chosen)
        found = list[bytes]()
        stream = b"".join(pieces) + as_sent(chosen[0]) * 45  # 64 kB: a segment's longest lead
        got.feed(rng, stream, lambda data: found.extend(one.jpeg for one in decoder.feed(data, 0)))  # noqa: B023
        got.count(found, known, [chosen[index] for index in intact])
        altered = sum(jpeg not in known and len(jpeg) in lengths for jpeg in found)
        got.altered += altered
        got.wrong -= altered
    return got


def proof(size: int, seed: int) -> dict[str, Figure]:
    """Feed ``size`` damaged parts in each of three forms."""
    result = dict[str, Figure]()
    for name, as_sent in ROWS.items():
        got = attack(size, seed, as_sent)
        most = size / 10_000  # header and image of one part damaged: no length left
        result[f"{name}: crashes"] = zero(got.crashes)
        limit = {"at_most" if name == "with Content-Length" else "at_least": most}
        result[f"{name}: images of a wrong length"] = Figure(got.wrong, **limit)
        result[f"{name}: images altered within"] = Figure(got.altered, of=got.accepted)
        result[f"{name}: intact images not found"] = Figure(got.lost, of=got.intact)
    return result
