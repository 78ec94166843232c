"""Writing one step: counts and raw bytes as MCAP, chunked and with checksums, readable after a kill."""

import contextlib
import hashlib
import os
from collections.abc import Collection
from pathlib import Path

import numpy as np

from procedures.arrays import FloatArray, IntArray
from procedures.counts.sample_records import RateSeries, SampleBlock, Series
from station.files.atomic_file import sync_folder
from station.files.mcap_files.new_file import new_channel, new_file
from station.files.mcap_files.schemas import COUNTS, COUNTS_TOPIC, MESSAGES, RATES, RAW, RAW_TOPIC, SCHEMA

_WORD = 0xFFFFFFFF


class StepWriter:
    """Writes a step's file; what was flushed survives a kill, a file is never overwritten.

    Call `flush` every 0.1 to 0.25 s while recording and `close` when the step is accepted. ``output`` is the
    message of ``/imu/counts``: counts, or rates for an IMU that reports a value in a linear unit.
    """

    def __init__(self, path: Path, output: str = COUNTS) -> None:
        self.path = path
        self._stream, self._writer = new_file(path)
        self._sample, self._raw = MESSAGES[output], MESSAGES[RAW]
        self._counts = new_channel(self._writer, COUNTS_TOPIC, output, SCHEMA)
        self._bytes = new_channel(self._writer, RAW_TOPIC, RAW, SCHEMA)
        self.samples = 0

    def write_raw(self, host_ns: int, data: bytes) -> None:
        """Write bytes as they were read from the port; ``host_ns`` is when, in ns since the epoch."""
        content = self._raw(data=data, host_ns=host_ns).SerializeToString()
        self._writer.add_message(self._bytes, log_time=host_ns, data=content, publish_time=host_ns)

    def write_block(
        self,
        host_ns: int,
        block: SampleBlock,
        triads: Collection[str] = ("gyro", "accel"),
        utc_s: float | None = None,
    ) -> None:
        """Write decoded frames, a message each; the device's time must be known [s].

        A triad that is not among ``triads`` is absent: the device does not measure it. ``utc_s`` [s since 1970] is
        reference time at ``host_ns``: of the last frame, the one that came then.
        """
        if not np.isfinite(block.device_time).all():
            raise ValueError("device_time is nan: give each frame its time before it is recorded")
        device_ns = np.rint(block.device_time * 1e9).astype(np.int64)
        counter, status = ((a & _WORD).tolist() for a in (np.maximum(block.counter, 0), block.status))
        gyro, accel = (getattr(block, name) if name in triads else None for name in ("gyro", "accel"))
        aux = None if utc_s is None else [*[dict[str, float]()] * (len(block) - 1), {"utc_s": utc_s}]
        host = np.full(len(block), host_ns)
        self._write(host, device_ns, gyro, accel, block.temperature, counter, status, aux)

    def write_series(self, series: Series, host_ns: IntArray | None = None) -> None:
        """Write a series; without ``host_ns`` (n,) the series' own time [s] is written for it too."""
        device_ns = np.rint(series.t * 1e9).astype(np.int64)
        zero = [0] * len(series)
        host = device_ns if host_ns is None else host_ns
        extra = [(name, values.tolist()) for name, values in series.extra.items()]
        aux = [{name: v[i] for name, v in extra if v[i] == v[i]} for i in range(len(series))] if extra else None
        self._write(host, device_ns, series.gyro, series.accel, series.temperature, zero, zero, aux)

    def _write(
        self,
        host_ns: IntArray,
        device_ns: IntArray,
        gyro: IntArray | FloatArray | None,
        accel: IntArray | FloatArray | None,
        temperature: FloatArray,
        counter: list[int],
        status: list[int],
        aux: list[dict[str, float]] | None = None,
    ) -> None:
        absent = [()] * len(device_ns)
        rows = zip(
            host_ns.tolist(),
            device_ns.tolist(),
            absent if gyro is None else gyro.tolist(),
            absent if accel is None else accel.tolist(),
            temperature.tolist(),
            counter,
            status,
            [{}] * len(device_ns) if aux is None else aux,
            strict=True,
        )
        for host, device, g, a, t, count, word, more in rows:
            sample = self._sample(
                device_ns=device, host_ns=host, gyro=g, accel=a, temperature_c=t, counter=count, status=word,
                aux=more,
            )  # fmt: skip
            self._writer.add_message(
                self._counts, log_time=host, data=sample.SerializeToString(), publish_time=host, sequence=count
            )
        self.samples += len(device_ns)

    def flush(self, *, sync: bool = True) -> None:
        """Close the chunk in progress and hand it to the system; with ``sync`` also to the disk."""
        self._writer.flush()  # type: ignore[no-untyped-call]
        if sync:
            os.fsync(self._stream.fileno())

    def close(self) -> str:
        """Finish the file on disk and return its sha256; a second call changes nothing."""
        if not self._stream.closed:
            try:
                self._writer.finish()  # type: ignore[no-untyped-call]
                self.flush()
            finally:
                self._stream.close()
            sync_folder(self.path.parent)
        with self.path.open("rb") as stream:
            return hashlib.file_digest(stream, "sha256").hexdigest()

    def abandon(self) -> None:
        """Let the file go and take it away, where it cannot be finished."""
        with contextlib.suppress(OSError):  # what is still to be written finds no room either
            self._stream.close()
        self.path.unlink(missing_ok=True)


def write_step(path: Path, series: Series) -> str:
    """Write a whole step's series to a new file and return its sha256."""
    writer = StepWriter(path, RATES if isinstance(series, RateSeries) else COUNTS)
    writer.write_series(series)
    return writer.close()
