"""The web server: textual-serve's, on the loopback only, behind a `Guard`, with a page that asks nobody else."""

import asyncio
import shlex
import socket
from collections.abc import Callable, Sequence
from pathlib import Path

from aiohttp import WSCloseCode, web
from textual_serve.server import Server, to_int

from station.tui.web.errors import PortTaken
from station.tui.web.guard import DOWNLOAD, Guard
from station.tui.web.tab import STOP_S, Tab

LOOPBACK = "127.0.0.1"  # what moves a bench is for this machine only
HEARTBEAT_S = 15.0  # a browser that vanished without a word is noticed within this
CLOSE_S = 2.0  # for a browser to say goodbye
HTTP_PORT = 80  # which browsers leave out
DEFAULT_TERMINAL_SIZE = {"width": 80, "height": 24}  # cells, where a tab does not say its own


class LoopbackServer(Server):
    """Serves ``command`` to each tab; `serve` blocks."""

    def __init__(
        self,
        command: Sequence[str],
        announce: Callable[[str], None],
        port: int,
        report: Callable[[], Path | None],
    ) -> None:
        self._socket = _listening(port)
        port = self._socket.getsockname()[1]
        self.guard = Guard(LOOPBACK if port == HTTP_PORT else f"{LOOPBACK}:{port}")
        self._announce, self._report = announce, report
        self._open: set[web.WebSocketResponse] = set()
        super().__init__(
            f"exec {shlex.join(command)}",  # no shell stays between us and the program
            LOOPBACK,
            port,
            title="station",
            public_url=f"http://{self.guard.authority}",
            templates_path=Path(__file__).with_name("templates"),
        )

    def serve(self, debug: bool = False) -> None:
        """Serve until SIGINT or SIGTERM; every tab's process has ended when this returns."""
        self.debug = debug
        web.run_app(
            self._make_app(), sock=self._socket, print=None, access_log=None, shutdown_timeout=CLOSE_S + STOP_S
        )

    async def on_startup(self, app: web.Application) -> None:
        """Say that browsers may come."""
        self._announce(self.guard.url)

    async def on_shutdown(self, app: web.Application) -> None:
        """End every tab."""
        await asyncio.gather(*(tab.close(code=WSCloseCode.GOING_AWAY) for tab in set(self._open)))

    async def handle_websocket(self, request: web.Request) -> web.WebSocketResponse:
        """Serve one tab for as long as it is open."""
        websocket = web.WebSocketResponse(heartbeat=HEARTBEAT_S, timeout=CLOSE_S)
        await websocket.prepare(request)
        tab = Tab(self.command, websocket, self.download_manager)
        width, height = (to_int(request.query.get(name, ""), size) for name, size in DEFAULT_TERMINAL_SIZE.items())
        self._open.add(websocket)
        try:
            await tab.start(width, height)
            await self._process_messages(websocket, tab)
        finally:
            self._open.discard(websocket)
            await tab.stop()
        return websocket

    async def handle_report(self, request: web.Request) -> web.Response:
        """Answer with the report as it is now."""
        path = self._report()
        try:
            content = await asyncio.to_thread(path.read_bytes) if path else b""
        except OSError as error:
            raise web.HTTPNotFound(text=f"{path}: no readable report ({error.strerror})\n") from error
        if not content:
            raise web.HTTPNotFound(text="there is no report yet: it is written with the verdict\n")
        return web.Response(body=content, content_type="text/html", charset="utf-8")

    async def _make_app(self) -> web.Application:
        app = web.Application(middlewares=[self.guard.middleware])
        app.on_response_prepare.append(self.guard.add_headers)
        app.router.add_get(self.guard.report, self.handle_report)
        app.add_subapp(f"/{self.guard.token}/", await super()._make_app())
        app.router.add_get(f"{DOWNLOAD}{{key}}", self.handle_download)
        return app


def _listening(port: int) -> socket.socket:
    try:
        return socket.create_server((LOOPBACK, port))
    except OSError as error:
        raise PortTaken(LOOPBACK, port, error.strerror or str(error)) from error
