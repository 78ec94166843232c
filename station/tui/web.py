"""The terminal screen in a browser of this machine; needs the extra ``web``.

CannotServe
├── PortTaken         somebody else listens there
└── WebNotInstalled   the extra is missing
"""

from collections.abc import Callable, Sequence
from pathlib import Path

from procedures.errors import ErrorCode
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


def serve(
    command: Sequence[str],
    announce: Callable[[str], None],
    *,
    port: int = 8000,
    report: Callable[[], Path | None] = lambda: None,
) -> None:
    """Serve a Textual program to browsers until Ctrl-C or SIGTERM; each tab has a process of its own.

    Whoever is to see one and the same thing in every tab runs it elsewhere and has ``command`` attach to it.
    A closed tab ends its process and nothing else.

    ``announce`` is called once, when browsers may come, with the one URL that is answered. It holds a secret:
    whoever knows it and is on this machine may drive the program. ``port`` 0: any free one. ``report`` says which
    file is shown at ``report`` below that URL, None while there is none.

    Raises
    ------
    PortTaken
        If somebody else listens there.
    WebNotInstalled
        Without the extra.
    """
    try:
        from station.tui.web_server import LOOPBACK, LoopbackServer
    except ModuleNotFoundError as error:
        raise WebNotInstalled(error.name or str(error)) from error
    try:
        server = LoopbackServer(command, announce, port, report)
    except OSError as error:
        raise PortTaken(LOOPBACK, port, error.strerror or str(error)) from error
    server.serve()
