"""What serving a browser can refuse.

CannotServe
├── NotLoopback       asked to listen where other machines could come
├── PortTaken         somebody else listens there
└── WebNotInstalled   the extra is missing
"""

from station.errors import StationError


class CannotServe(StationError):
    """No browser can be served."""


class NotLoopback(CannotServe, ValueError):
    """An address that other machines could reach."""

    def __init__(self, host: str, expected: tuple[str, ...]) -> None:
        self.host, self.expected = host, expected
        super().__init__(
            f"found host {host!r}, expected {' or '.join(expected)}: the bench is driven from this machine only; "
            f"from another one use ssh, as in `ssh -L 8000:127.0.0.1:8000 STATION`"
        )


class PortTaken(CannotServe, OSError):
    """The port cannot be listened on."""

    def __init__(self, host: str, port: int, reason: str) -> None:
        self.host, self.port, self.reason = host, port, reason
        super().__init__(
            f"{host} port {port}: cannot listen ({reason}); choose another port, or 0 for any free one"
        )


class WebNotInstalled(CannotServe, ImportError):
    """A package of the extra is not there."""

    def __init__(self, package: str) -> None:
        self.package = package
        super().__init__(f"the package {package} is missing; install it with `pip install 'fog-station[web]'`")
