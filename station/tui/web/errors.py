"""What serving a browser can refuse.

CannotServe
├── PortTaken         somebody else listens there
└── WebNotInstalled   the extra is missing
"""

from procedures.error_codes import ErrorCode
from procedures.optional_libraries import install_command
from station.errors import StationError


class CannotServe(StationError):
    """No browser can be served."""

    code = ErrorCode.BROWSER


class PortTaken(CannotServe, OSError):
    """The port cannot be listened on."""

    def __init__(self, host: str, port: int, reason: str) -> None:
        self.host, self.port, self.reason = host, port, reason
        super().__init__(
            f"{host} port {port}: cannot listen ({reason}); choose another port, or 0 for any free one"
        )


class WebNotInstalled(CannotServe, ImportError):
    """A package of the extra is not there."""

    code = ErrorCode.EXTRA_MISSING

    def __init__(self, package: str) -> None:
        self.package = package
        super().__init__(
            f"found no package {package}, expected the extra `web`; install it with `{install_command('web')}` in "
            "the station's folder"
        )
