"""The terminal screen in a browser of this machine; needs the extra ``web``."""

from collections.abc import Callable, Sequence
from pathlib import Path

from station.tui.web.errors import WebNotInstalled


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

    ``announce`` is told once, when browsers may come, the one URL that is answered. It holds a secret: whoever
    knows it and is on this machine may drive the program. ``port`` 0: any free one. ``report`` says which file is
    shown at ``report`` below that URL, None while there is none.

    Raises
    ------
    PortTaken
        If somebody else listens there.
    WebNotInstalled
        Without the extra.
    """
    try:
        from station.tui.web.server import LoopbackServer
    except ModuleNotFoundError as error:
        raise WebNotInstalled(error.name or str(error)) from error
    LoopbackServer(command, announce, port, report).serve()
