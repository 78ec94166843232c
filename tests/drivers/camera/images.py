"""JPEG images for tests, of which each is another."""

import functools

import numpy as np
import pytest

WIDTH, HEIGHT = 64, 48


@functools.cache
def jpegs(count: int = 4, seed: int = 0, quality: int = 80) -> tuple[bytes, ...]:
    """Return images of noise, so that their scans have stuffed 0xFF in them."""
    cv = pytest.importorskip("cv2", reason="opencv is not installed")
    rng, options = np.random.default_rng(seed), [cv.IMWRITE_JPEG_QUALITY, quality, cv.IMWRITE_JPEG_RST_INTERVAL, 5]
    found = (cv.imencode(".jpg", rng.integers(0, 255, (HEIGHT, WIDTH), np.uint8), options) for _ in range(count))
    return tuple(bytes(encoded) for _, encoded in found)


def with_thumbnail(jpeg: bytes, thumbnail: bytes) -> bytes:
    """Return an image that has a smaller one within an APP1 segment, as EXIF has it."""
    return jpeg[:2] + b"\xff\xe1" + (len(thumbnail) + 2).to_bytes(2, "big") + thumbnail + jpeg[2:]
