"""The reader process: ``python -m station.stream.reader URL [FILE]``; messages on stdout until stdin is closed.

It holds no lock that another process could keep and knows nothing of frames: read, stamp, record, stream.
"""

import os
import sys
import threading
import time
from datetime import UTC, datetime
from pathlib import Path

from drivers.address_parsing import parse_device_url
from drivers.addresses import DeviceAddress
from drivers.errors import DriverError
from drivers.ports import frame_descriptions
from station.errors import CannotWrite
from station.files.mcap_files.schemas import CAMERA_RAW_TOPIC, GNSS_RAW_TOPIC, RAW_TOPIC, WHEEL_RAW_TOPIC
from station.stream.reader.messages import Chunk, Item, Outbox, Quiet, Refusal, StreamGap, packed
from station.stream.reader.raw_recording import RawRecording
from station.stream.reader.reconnecting_port import ReconnectingPort

READ_BYTES = 65536
FAREWELL_S = 2.0
# what stands alongside an IMU; its own is RAW_TOPIC
TOPICS = {"mavlink": GNSS_RAW_TOPIC, "camera": CAMERA_RAW_TOPIC, "wheel": WHEEL_RAW_TOPIC}


def main(url: str, recording: str = "") -> None:
    """Read a device until the station stops it; without a recording the bytes are streamed and not kept."""
    messages = os.dup(sys.stdout.fileno())
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # a stray print must not be taken for a message
    outbox = Outbox(messages)
    try:
        _Session(parse_device_url(url), Path(recording) if recording else None, outbox).run()
    except (DriverError, CannotWrite) as error:
        outbox.put(packed(Refusal(type(error), str(error), vars(error))), always=True)
    outbox.close(FAREWELL_S)
    os._exit(0)  # a thread that waits for stdin must not hold us


class _Session:
    """One device, one recording or none, one station."""

    def __init__(self, url: DeviceAddress, recording: Path | None, outbox: Outbox) -> None:
        self._url, self._outbox = url, outbox
        self._stop = threading.Event()
        self._failure: CannotWrite | None = None
        self._since = time.time_ns() - time.monotonic_ns()  # wall time is looked at once
        self._refused = 0  # bytes that the station did not collect
        described = frame_descriptions(url)
        self._port = ReconnectingPort(url, self._stop, self._mark)
        began = {"started_utc": datetime.now(UTC).isoformat(), "host_ns": str(self._now())}
        session = {"url": url.public_text, **began, **described}
        topic = TOPICS.get(url.scheme, RAW_TOPIC)
        self._recording = None if recording is None else RawRecording(recording, session, self._failed, topic)

    def run(self) -> None:
        """Read until the station closes stdin, the replay ends or the recording cannot be written."""
        threading.Thread(target=self._watch_stdin, daemon=True).start()
        self._outbox.put(packed(Quiet(self._now())))
        try:
            while not self._stop.is_set():
                data = self._port.read(READ_BYTES)
                if data:
                    self._hand_on(Chunk(self._now(), data))
                elif self._url.scheme in TOPICS:  # whoever merges it with another stream waits for this
                    self._outbox.put(packed(Quiet(self._now())))
        finally:
            self._port.close()
            if self._recording is not None:
                self._recording.close()
            if self._failure is not None:
                raise self._failure

    def _hand_on(self, chunk: Chunk) -> None:
        self._keep(chunk)
        message = packed(chunk)
        if self._url.scheme == "replay":  # a file can wait, a device cannot
            while not self._outbox.put(message) and not self._stop.is_set():
                self._outbox.wait_for_room(0.1)
        elif self._refused or not self._outbox.put(message):
            self._refuse(message, chunk)

    def _refuse(self, message: bytes, chunk: Chunk) -> None:
        if self._refused:
            where = "they are in the recording only" if self._recording is not None else "they are lost"
            reason = f"{self._refused} bytes not collected in time; {where}"
            if self._outbox.put(packed(StreamGap(chunk.host_ns, reason, True))):
                self._refused = 0 if self._outbox.put(message) else len(chunk.data)
                return
        self._refused += len(chunk.data)

    def _mark(self, reason: str, is_open: bool) -> None:
        mark = StreamGap(self._now(), reason, is_open)
        self._keep(mark)
        self._outbox.put(packed(mark), always=True)

    def _keep(self, item: Item) -> None:
        if self._recording is not None:
            self._recording.put(item)

    def _failed(self, error: CannotWrite) -> None:
        self._failure = error
        self._stop.set()

    def _watch_stdin(self) -> None:
        while os.read(0, 1):
            pass
        self._stop.set()

    def _now(self) -> int:
        return self._since + time.monotonic_ns()


if __name__ == "__main__":
    main(*sys.argv[1:3])
