"""Samples in Foxglove's live server, a WebSocket: topic ``/imu/calibrated``, one message a sample; and a layout.

The server is the SDK's own: its threads send, so that no client delays another or the samples. Each client has a
bounded queue; where it is full the SDK drops the oldest and logs it, and the client sees ``sequence`` jump. The
layout has the form in which Foxglove imports them: each panel's settings by its name, a tree of splits.
"""

import json
import logging
import re
from pathlib import Path
from typing import Any

import numpy as np

from drivers.errors import PortBusy, PortNotFound
from procedures.optional_libraries import ExtraMissing
from station.files.atomic_file import replace_file
from station.files.mcap_files.schemas import COLUMNS, FIELDS, SAMPLE, TOPIC, built, sample_message
from station.sending.outputs import About, CalibratedSamples, Quality, peer_of
from station.text import plural

FLAGS = tuple((flag, str(flag.name).lower()) for flag in Quality)
SCHEMA, _MESSAGES = built(sample_message(FIELDS, [name for _, name in FLAGS]))
CalibratedSample: Any = _MESSAGES[SAMPLE]


HOST, PORT = "127.0.0.1", 8765  # Foxglove's own port
MAX_WAITING = 4096  # messages a client: two seconds of 2 kHz
EXPECTED = "foxglove, or foxglove:HOST:PORT"
FULL = re.compile(r"outbox for client (\S+) full")


class FoxgloveServer:
    """The SDK's server with one topic; who subscribes gets what comes from then on."""

    is_over = False
    dropped = None  # the SDK does not count

    def __init__(self, sdk: Any, host: str, port: int, about: About) -> None:
        self._slow, self._clients = SlowClients(), Clients()
        self._slow.listen(sdk)
        context = self._context = sdk.Context()  # the SDK releases a context that nobody holds
        name = f"{about.model} {about.serial}, {about.calibration}"
        try:
            self._server = sdk.start_server(
                name=name, host=host, port=port, context=context, server_listener=self._clients,
                message_backlog_size=MAX_WAITING,
            )  # fmt: skip
        except RuntimeError as error:  # what the SDK makes of every refusal
            self._slow.leave()
            raise _refusal(host, port, str(error)) from error
        schema = sdk.Schema(name=SAMPLE, encoding="protobuf", data=SCHEMA)
        metadata = {
            "model": about.model, "serial": about.serial, "calibration": about.calibration, "axes": about.axes,
        }  # fmt: skip
        self._channel = sdk.Channel(
            TOPIC, message_encoding="protobuf", schema=schema, context=context, metadata=metadata
        )
        self.name = f"foxglove:{host}:{self._server.port}"

    def send(self, samples: CalibratedSamples) -> None:
        """Send samples to those who subscribed."""
        if not self._channel.has_sinks():
            return
        six = np.hstack((samples.f, samples.omega)).tolist()
        rows = zip(
            samples.sequence.tolist(), samples.t.tolist(), samples.utc.tolist(), six, samples.temperature.tolist(),
            samples.lost.tolist(), samples.flags.tolist(), samples.taken_ns.tolist(), strict=True,
        )  # fmt: skip
        for sequence, t, utc, values, temperature, lost, flags, taken_ns in rows:
            message = CalibratedSample(
                sequence=sequence, t_s=t, utc_s=utc, temperature_c=temperature, lost=lost, flags=flags,
                **dict(zip(COLUMNS, values, strict=True)), **{name: True for flag, name in FLAGS if flag & flags},
            )  # fmt: skip
            self._channel.log(message.SerializeToString(), log_time=taken_ns)

    def status(self) -> str:
        """Return how many listen, and who is slow."""
        slow = ", ".join(self._slow.met)
        dropped = f", samples dropped for {slow}: too slow" if slow else ""
        return f"{self.name}: {plural(self._clients.count, 'client')}{dropped}"

    def close(self) -> None:
        """End the server."""
        self._clients.is_over = True
        self._channel.close()
        self._server.stop()
        self._slow.leave()


class Clients:
    """Counts who has subscribed, until ``is_over`` is set; the SDK calls it from threads of its own."""

    def __init__(self) -> None:
        self._ids: set[int] = set()
        self.is_over = False

    @property
    def count(self) -> int:
        """How many there are now."""
        return len(self._ids)

    def on_subscribe(self, client: Any, channel: Any) -> None:
        """Take note of a client."""
        self._ids.add(client.id)

    def on_unsubscribe(self, client: Any, channel: Any) -> None:
        """Let a client go."""
        if not self.is_over:
            self._ids.discard(client.id)


class SlowClients(logging.Handler):
    """Learns from the SDK's log whose queue is full: nothing else reports it; ``met`` are their addresses."""

    def __init__(self) -> None:
        super().__init__(logging.INFO)
        self.met: dict[str, None] = {}

    def listen(self, sdk: Any) -> None:
        """Begin; what the SDK logs goes nowhere else."""
        if not logging.getLogger().handlers:
            logging.getLogger().addHandler(logging.NullHandler())  # else the SDK sets up a log on stderr
        log = logging.getLogger("foxglove")
        log.propagate = False
        log.setLevel(logging.INFO)
        log.addHandler(self)
        sdk.set_log_level(logging.INFO)

    def emit(self, record: logging.LogRecord) -> None:
        """Take note of whose queue is full."""
        if found := FULL.search(record.getMessage()):
            self.met[found[1]] = None

    def leave(self) -> None:
        """Stop listening."""
        logging.getLogger("foxglove").removeHandler(self)


def open_output(where: str, about: About) -> FoxgloveServer:
    """Return a server at HOST:PORT, on this machine alone where none is named.

    Raises
    ------
    ExtraMissing
        If the SDK is not installed.
    BadAddress, PortBusy, PortNotFound
        What the address refuses.
    """
    try:
        import foxglove
    except ImportError:
        raise ExtraMissing("foxglove", "foxglove") from None
    host, port = peer_of("foxglove", where, EXPECTED, least=0) if where else (HOST, PORT)
    return FoxgloveServer(foxglove, host, port, about)


def _refusal(host: str, port: int, text: str) -> PortBusy | PortNotFound:
    if "in use" in text:
        return PortBusy(f"{port}/tcp")
    reason = re.sub(r" \(os error \d+\)", "", text).rpartition(": ")[2]
    return PortNotFound(f"{host}:{port}", reason, "use an address of this machine")


COLOURS = ("#d62728", "#2ca02c", "#1f77b4")  # x, y, z
FORCE, RATE, TEMPERATURE, FLAGS_PANEL, MESSAGE = (
    "Plot!force", "Plot!rate", "Plot!temperature", "StateTransitions!flags", "RawMessages!sample",
)  # fmt: skip


def write_layout(file: Path) -> None:
    """Write the layout; raise `CannotWrite` if that is refused."""
    replace_file(file, (json.dumps(layout(), indent=1) + "\n").encode())


def layout() -> dict[str, Any]:
    """Return the layout as Foxglove's JSON."""
    panels = {
        FORCE: _plot("Specific force [m/s2]", COLUMNS[:3]),
        RATE: _plot("Angular rate [rad/s]", COLUMNS[3:]),
        TEMPERATURE: _plot("Temperature [degC]", ("temperature_c",)),
        FLAGS_PANEL: {"isSynced": True, "paths": [{"value": f"{TOPIC}.flags", "timestampMethod": "receiveTime"}]},
        MESSAGE: {"topicPath": TOPIC},
    }
    below = _split("row", TEMPERATURE, _split("row", FLAGS_PANEL, MESSAGE, 55), 40)
    return {
        "configById": panels, "globalVariables": {}, "userNodes": {}, "playbackConfig": {"speed": 1},
        "layout": _split("column", FORCE, _split("column", RATE, below, 55), 38),
    }  # fmt: skip


def _plot(title: str, fields: tuple[str, ...]) -> dict[str, Any]:
    paths = [
        {"value": f"{TOPIC}.{field}", "enabled": True, "timestampMethod": "receiveTime", "color": colour}
        for field, colour in zip(fields, COLOURS, strict=False)
    ]
    return {
        "title": title, "paths": paths, "isSynced": True, "xAxisVal": "timestamp", "followingViewWidth": 20,
        "showLegend": True, "legendDisplay": "floating", "showXAxisLabels": True, "showYAxisLabels": True,
        "showPlotValuesInLegend": True,
    }  # fmt: skip


def _split(direction: str, first: Any, second: Any, percentage: float) -> dict[str, Any]:
    return {"direction": direction, "first": first, "second": second, "splitPercentage": percentage}
