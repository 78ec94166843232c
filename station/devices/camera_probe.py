"""A short look at what a camera sends, recording nothing."""

import time
from dataclasses import dataclass

import numpy as np

from drivers.address_parsing import parse_device_url
from drivers.camera import CameraDecoder, CameraImage
from drivers.camera.decoder import CameraCounters
from drivers.camera.jpeg import jpeg_size
from drivers.errors import LinkSilent, WrongFormat
from drivers.ports import open_port
from station.devices.imu_probe import READ_BYTES
from station.text.plural import plural

FORMAT = "MJPEG"


@dataclass(frozen=True, slots=True)
class CameraProbe:
    """What came within ``seconds``; ``rate_hz`` is by the sender's stamps, None where it sends none.

    ``sizes`` are the images' widths and heights [px], one unless they change.
    """

    seconds: float
    bytes: int
    images: int
    sizes: tuple[tuple[int, int], ...]
    rate_hz: float | None
    counters: CameraCounters

    @property
    def size(self) -> str:
        """Width and height [px] in words."""
        return ", then ".join(f"{width} x {height} px" for width, height in self.sizes)

    @property
    def errors(self) -> dict[str, int]:
        """What the decoder counted beside images."""
        counters = self.counters
        return {"cut": counters.cut, "not_jpeg": counters.not_jpeg, "skipped_bytes": counters.skipped_bytes}

    def lines(self) -> list[str]:
        """Return it in lines."""
        rate = "no stamps" if self.rate_hz is None else f"{self.rate_hz:.6g} Hz by its own time"
        return [
            f"format    {FORMAT}",
            f"size      {self.size}",
            f"received  {self.images / self.seconds:.1f} images/s, {self.bytes / self.seconds:.0f} bytes/s",
            f"rate      {rate}",
            f"errors    {_troubles(self.counters)}",
        ]


def _troubles(counters: CameraCounters) -> str:
    cut, other, skipped = plural(counters.cut, "image"), plural(counters.not_jpeg, "part"), counters.skipped_bytes
    return f"{cut} cut short or broken, {other} of another kind, {plural(skipped, 'byte')} in no image"


def probe_camera(url: str, seconds: float, timeout_s: float = 0.05) -> CameraProbe:
    """Read a camera for ``seconds``.

    Raises
    ------
    DriverError
        If it cannot be opened, no byte comes, or no image is among them.
    """
    address = parse_device_url(url, "camera")
    decoder, images, came = CameraDecoder(), list[CameraImage](), 0
    port = open_port(address, timeout_s)
    began = time.monotonic()
    try:
        while (took := time.monotonic() - began) < seconds:
            data = port.read(READ_BYTES)
            came += len(data)
            images += decoder.feed(data, time.monotonic_ns())
    finally:
        port.close()
    if not came:
        raise LinkSilent(address.name, seconds, advice="check that the camera is on and not in use elsewhere")
    if not images:
        seen = f"{_troubles(decoder.counters)}; look for longer, or check what it sends"
        raise WrongFormat(address.name, "JPEG", came, seen=seen)
    sizes = tuple(dict.fromkeys(jpeg_size(image.jpeg) for image in images))
    return CameraProbe(took, came, len(images), sizes, _rate(images), decoder.counters)


def _rate(images: list[CameraImage]) -> float | None:
    stamps = np.array([image.device_ns for image in images if image.device_ns is not None], np.int64)
    steps = np.diff(stamps)
    steps = steps[steps > 0]
    return float(1e9 / np.median(steps)) if len(steps) else None
