"""A WebSocket client of Foxglove's server, which reads by what the server tells."""

import base64
import json
import struct
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from google.protobuf.descriptor_pb2 import FileDescriptorSet
from google.protobuf.descriptor_pool import DescriptorPool
from google.protobuf.message_factory import GetMessageClass
from websockets.exceptions import InvalidHandshake
from websockets.sync.client import ClientConnection, connect

from tests.patience import HANG_S, until

SUBSCRIPTION = 7


@contextmanager
def connected(port: int, **options: Any) -> Iterator[ClientConnection]:
    """Connect to a server that may not be there yet."""
    found = list[ClientConnection]()

    def attempt() -> None:
        try:
            found.append(connect(f"ws://127.0.0.1:{port}", subprotocols=["foxglove.sdk.v1"], **options))
        except (OSError, InvalidHandshake):
            time.sleep(0.05)

    until(lambda: found, attempt)
    with found[0] as client:
        yield client


def advertised(client: ClientConnection) -> dict[str, Any]:
    """Return the first channel that a server tells of."""
    while True:
        received = json.loads(client.recv(timeout=HANG_S))
        if received["op"] == "advertise":
            channel: dict[str, Any] = received["channels"][0]
            return channel


def subscribe(client: ClientConnection) -> Callable[[bytes], Any]:
    """Subscribe to the first channel; return what reads its messages by the schema that the server tells."""
    channel = advertised(client)
    ask_for(client, channel)
    return reader_of(channel)


def ask_for(client: ClientConnection, channel: dict[str, Any]) -> None:
    """Subscribe to a channel."""
    asked = {"op": "subscribe", "subscriptions": [{"id": SUBSCRIPTION, "channelId": channel["id"]}]}
    client.send(json.dumps(asked))


def reader_of(channel: dict[str, Any]) -> Callable[[bytes], Any]:
    """Return what reads a channel's messages by its own schema, as Foxglove does."""
    pool = DescriptorPool()
    for file in FileDescriptorSet.FromString(base64.b64decode(channel["schema"])).file:
        pool.Add(file)
    kind = GetMessageClass(pool.FindMessageTypeByName(channel["schemaName"]))
    return lambda data: kind.FromString(data)


def messages(client: ClientConnection) -> Iterator[tuple[int, bytes]]:
    """Yield log time [ns] and payload of each message until the server ends."""
    for data in client:
        if isinstance(data, bytes):
            opcode, subscription, log_ns = struct.unpack_from("<BIQ", data)
            assert (opcode, subscription) == (1, SUBSCRIPTION)
            yield log_ns, data[13:]
