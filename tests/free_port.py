"""A UDP port for one test alone, also where others run at once."""

import socket


def free_udp_port() -> int:
    """Return a port that nobody holds now."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("", 0))
        return int(probe.getsockname()[1])
