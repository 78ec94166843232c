"""A listener for datagrams."""

import socket
from collections.abc import Iterator
from contextlib import contextmanager

from tests.patience import HANG_S


@contextmanager
def listener() -> Iterator[socket.socket]:
    """Listen for datagrams on a free port."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as bound:
        bound.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 2**22)
        bound.bind(("127.0.0.1", 0))
        bound.settimeout(HANG_S)
        yield bound
