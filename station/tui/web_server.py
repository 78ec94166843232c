"""The web server: textual-serve's, on the loopback only, behind a `Guard`, with a page that asks nobody else.

Only pages of this server may ask, and they know its secret. A foreign page in the same browser can send requests
here but not choose their ``Origin``; a page whose name was bound again to 127.0.0.1 (DNS rebinding) has its own
name in ``Host``. Neither of them, nor another user of this machine, knows the token in the path.
"""

import asyncio
import secrets
import shlex
import socket
from asyncio.subprocess import Process
from collections.abc import Awaitable, Callable, Sequence
from pathlib import Path

from aiohttp import WSCloseCode, web
from textual_serve.app_service import AppService
from textual_serve.download_manager import DownloadManager
from textual_serve.server import Server, to_int

REPORT_PATH = "report"  # below the secret; a document, which may do nothing
DOWNLOAD = "/download/"  # the page asks for it by this name; what follows is a secret of its own
Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]


class Guard:
    """Refuses what does not come from this server's page; ``authority`` is its HOST:PORT as browsers say it."""

    def __init__(self, authority: str) -> None:
        self.authority = authority
        self.token = secrets.token_urlsafe(24)
        self.url = f"http://{authority}/{self.token}/"  # the address of the page
        self.report = f"/{self.token}/{REPORT_PATH}"  # the path of the report

    def fault(self, request: web.Request) -> str:
        """Return why a request is refused, empty if it is not."""
        own = f"http://{self.authority}"
        if (host := request.headers.get("Host", "")) != self.authority:
            return f"found Host {host!r}, expected {self.authority!r}"
        if (origin := request.headers.get("Origin", own)) != own:
            return f"found Origin {origin!r}, expected {own!r}"
        token = request.path.lstrip("/").partition("/")[0].encode()
        if request.path.startswith(DOWNLOAD) or secrets.compare_digest(token, self.token.encode()):
            return ""
        return "the address does not contain this server's secret"

    @web.middleware
    async def middleware(self, request: web.Request, handler: Handler) -> web.StreamResponse:
        """Answer 403 to what is refused."""
        if fault := self.fault(request):
            raise web.HTTPForbidden(text=f"{fault}; open the address that the station printed\n")
        return await handler(request)

    async def add_headers(self, request: web.Request, response: web.StreamResponse) -> None:
        """Have the browser ask nobody else, show the page in no other, and send its address to nobody.

        The report runs nothing at all: what was typed into a form stands in it.
        """
        page = (
            f"default-src 'self'; connect-src 'self' ws://{self.authority}; img-src 'self' data:; "
            f"script-src 'self' 'unsafe-inline'; style-src 'self' 'unsafe-inline'; frame-ancestors 'none'"
        )
        document = "sandbox; default-src 'none'; img-src data:; font-src data:; style-src 'unsafe-inline'"
        response.headers.update(
            {
                "Content-Security-Policy": document if request.path == self.report else page,
                "Referrer-Policy": "no-referrer",
                "Cache-Control": "no-store",
                "X-Content-Type-Options": "nosniff",
            }
        )


STOP_S = 3.0  # for a program to end when it is asked to


class Tab(AppService):
    """Ends with its tab, whatever its program does; the tab ends with its program, however that ends."""

    def __init__(self, command: str, websocket: web.WebSocketResponse, downloads: DownloadManager) -> None:
        self._websocket = websocket
        super().__init__(
            command, write_bytes=websocket.send_bytes, write_str=websocket.send_str, close=self._close,
            download_manager=downloads,
        )  # fmt: skip

    async def run(self) -> None:
        """Stream what the program draws until it has ended."""
        try:
            await super().run()
        finally:
            await self._close()

    async def stop(self) -> None:
        """Tell the program to end, and end it if it does not."""
        if self._process is None:
            return
        ending = asyncio.create_task(self._end(self._process))
        try:
            await asyncio.wait({ending}, timeout=STOP_S)
        finally:  # also where the server is in a hurry itself
            if self._process.returncode is None:
                self._process.kill()
        await ending

    async def _end(self, process: Process) -> None:
        await super().stop()
        await process.wait()

    async def _close(self) -> None:
        await self._websocket.close()


LOOPBACK = "127.0.0.1"  # what moves a bench is for this machine only
HEARTBEAT_S = 15.0  # a browser that vanished without a word is noticed within this
CLOSE_S = 2.0  # for a browser to say goodbye
HTTP_PORT = 80  # which browsers leave out
DEFAULT_TERMINAL_SIZE = {"width": 80, "height": 24}  # cells, where a tab does not say its own


class LoopbackServer(Server):
    """Serves ``command`` to each tab; `serve` blocks."""

    def __init__(
        self, command: Sequence[str], announce: Callable[[str], None], port: int, report: Callable[[], Path | None]
    ) -> None:
        self._socket = socket.create_server((LOOPBACK, port))
        port = self._socket.getsockname()[1]
        self.guard = Guard(LOOPBACK if port == HTTP_PORT else f"{LOOPBACK}:{port}")
        self._announce, self._report = announce, report
        self._open: set[web.WebSocketResponse] = set()
        super().__init__(
            f"exec {shlex.join(command)}", LOOPBACK, port,  # no shell stays between us and the program
            title="station", public_url=f"http://{self.guard.authority}",
            templates_path=Path(__file__).with_name("templates"),
        )  # fmt: skip

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
