"""A little screen in place of the station's: tells the engine of every key, shows the colour that the engine says.

``b`` rings, ``d`` hands out a file, ``q`` ends it, ``x`` kills it, ``w`` freezes it.
"""

import io
import os
import signal
import socket
import sys
from threading import Thread

from textual import events
from textual.app import App


class LittleApp(App[None]):
    ENABLE_COMMAND_PALETTE = False

    def __init__(self, engine: str) -> None:
        super().__init__()
        self._engine = socket.socket(socket.AF_UNIX)
        self._engine.connect(engine)
        self._report(f"{os.getpid()}")

    def on_mount(self) -> None:
        Thread(target=self._listen, daemon=True).start()

    def on_unmount(self) -> None:
        self._report("ended")

    def on_key(self, event: events.Key) -> None:
        self._report(event.key)
        match event.key:
            case "b":
                self.bell()
            case "d":
                self.deliver_text(io.StringIO("the report"), save_filename="report.txt")
            case "q":
                self.exit()
            case "x":
                os.kill(os.getpid(), signal.SIGKILL)
            case "w":
                os.kill(os.getpid(), signal.SIGSTOP)

    def _report(self, line: str) -> None:
        self._engine.sendall(line.encode() + b"\n")

    def _listen(self) -> None:
        for line in self._engine.makefile():
            self.call_from_thread(self._show, line.strip())
        self.call_from_thread(self.exit)

    def _show(self, colour: str) -> None:
        self.screen.styles.background = colour


if __name__ == "__main__":
    LittleApp(sys.argv[1]).run()
