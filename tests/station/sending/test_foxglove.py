"""Foxglove's live server by a WebSocket client on a real socket, which reads by what the server tells."""

import threading

import numpy as np
import pytest

from station.files.mcap_files.schemas import COLUMNS
from station.sending.outputs import Quality, open_outputs
from tests.free_port import free_tcp_port
from tests.patience import until
from tests.station.sending.test_outputs import ABOUT, made

pytest.importorskip("foxglove")
pytest.importorskip("websockets")
from tests.station.sending.clients import advertised, ask_for, connected, messages, reader_of, subscribe

BURST = 2000  # half of what waits for a client at most


def test_topic_schema_values_and_times_are_those_sent() -> None:
    port, samples = free_tcp_port(), made(6)
    (server,) = open_outputs([f"foxglove:127.0.0.1:{port}"], ABOUT)
    with connected(port) as client:
        channel = advertised(client)
        assert (channel["topic"], channel["encoding"]) == ("/imu/calibrated", "protobuf")
        assert channel["schemaName"] == "station.CalibratedSample"
        read = reader_of(channel)
        ask_for(client, channel)
        until(lambda: "1 client" in server.status())
        server.send(samples)
        found = [(log_ns, read(data)) for _, (log_ns, data) in zip(range(6), messages(client), strict=False)]
    until(lambda: "0 clients" in server.status())
    server.close()
    six = np.hstack((samples.f, samples.omega))
    for i, (log_ns, message) in enumerate(found):
        assert log_ns == samples.taken_ns[i]
        assert (message.sequence, message.t_s, message.lost) == (i, samples.t[i], samples.lost[i])
        assert [getattr(message, name) for name in COLUMNS] == six[i].tolist()
        for name in ("utc_s", "temperature_c"):
            known = (samples.utc if name == "utc_s" else samples.temperature)[i]
            assert getattr(message, name) == pytest.approx(known, rel=0, abs=0, nan_ok=True)
        set_ = {flag for flag in Quality if getattr(message, str(flag.name).lower())}
        assert message.flags == samples.flags[i] == sum(set_)


def test_a_client_that_does_not_read_holds_up_neither_samples_nor_others() -> None:
    port = free_tcp_port()
    (server,) = open_outputs([f"foxglove:127.0.0.1:{port}"], ABOUT)
    came, is_over = list[int](), threading.Event()
    with connected(port) as reading, connected(port, max_queue=1, close_timeout=0.1) as asleep:
        read = subscribe(reading)
        subscribe(asleep)
        until(lambda: "2 clients" in server.status())

        def listen() -> None:
            for _, data in messages(reading):
                came.append(read(data).sequence)
                if is_over.is_set():
                    return

        thread = threading.Thread(target=listen)
        thread.start()
        sent = 0

        def burst() -> None:
            nonlocal sent
            server.send(made(BURST, sent))
            sent += BURST
            until(lambda: came and came[-1] == sent - 1)  # so that the one that reads is never behind

        until(lambda: "too slow" in server.status(), burst)
        is_over.set()
        server.send(made(1, sent))
        thread.join()
        assert came == list(range(sent + 1))
        address = ":".join(map(str, asleep.local_address[:2]))
        assert server.status().endswith(f"samples dropped for {address}: too slow")
    server.close()
