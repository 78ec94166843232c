"""Print what a camera costs: `python -m tests.benchmarks.camera_cost`.

Processor time of one core: rendering an image with noise and JPEG, decoding MB/s of a stream in reads of 64 KiB,
and the reader process's share while it reads and journals a simulated camera at 20 Hz.
"""

import argparse
import os
import time
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from drivers.camera import CameraDecoder
from drivers.camera.multipart import part
from drivers.simulated.camera_images import CameraImages
from drivers.simulated.camera_server import SimulatedCamera
from drivers.simulated.camera_truth import CameraTruth
from drivers.simulated.truth import Truth
from station.stream.reader import Reader
from tests.drivers.simulated.drives import bends

RENDER_MS, DECODE_MB_S, READER_PERCENT = 15.0, 100.0, 5.0
READ, WARM_S = 65536, 2.0


def render_ms() -> float:
    """Return the median [ms] of a part's processor time along a track."""
    images, took = CameraImages(Truth.example(1), CameraTruth(), track=bends(60.0)), list[float]()
    for t in np.arange(0.0, 50.0, 0.5):
        began = time.process_time()
        images.part(float(t))
        took.append(time.process_time() - began)
    return float(np.median(took[1:]) * 1e3)


def decode_mb_s() -> float:
    """Return the decoder's pace [MB/s]."""
    images = CameraImages(Truth(), CameraTruth())
    stream = b"".join(part(images.jpeg(t / 15), t / 15) for t in range(20)) * 200
    decoder, began = CameraDecoder(), time.process_time()
    found = sum(len(decoder.feed(stream[at : at + READ], at)) for at in range(0, len(stream), READ))
    assert found == 4000
    return len(stream) / 1e6 / (time.process_time() - began)


def reader_percent(seconds: float) -> tuple[float, float]:
    """Return the reader process's share of a core [%] at 20 Hz, and the images/s that came."""
    decoder, images, camera = CameraDecoder(), 0, SimulatedCamera(Truth(), CameraTruth(rate_hz=20.0))
    with TemporaryDirectory() as folder, camera, Reader(camera.url, Path(folder) / "camera.mcap") as reader:
        began, spent = time.monotonic() + WARM_S, 0.0
        while (now := time.monotonic()) < began + seconds:
            if now < began:
                spent, images = cpu_s(reader.pid), 0
            for item in reader.poll(0.2):
                images += len(decoder.feed(item.data, item.host_ns)) if hasattr(item, "data") else 0
        return 100 * (cpu_s(reader.pid) - spent) / seconds, images / seconds


def cpu_s(pid: int) -> float:
    """Return the processor time [s] that a process has used."""
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def main() -> int:
    """Print the figures; exit 1 where one is worse than asked."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--seconds", type=float, default=20.0, help="of reading")
    seconds = parser.parse_args().seconds
    rendered, decoded = render_ms(), decode_mb_s()
    share, came = reader_percent(seconds)
    print(f"rendering   {rendered:6.1f} ms an image of 376 x 240 px (asked: {RENDER_MS:g})")
    print(f"decoding    {decoded:6.0f} MB/s (asked: {DECODE_MB_S:g})")
    print(f"reading     {share:6.1f} % of a core at {came:.1f} images/s (asked: {READER_PERCENT:g})")
    return 0 if rendered < RENDER_MS and decoded > DECODE_MB_S and share < READER_PERCENT else 1


if __name__ == "__main__":
    raise SystemExit(main())
