"""Who may ask: pages of this server only, and they know its secret.

A foreign page in the same browser can send requests here but not choose their ``Origin``; one whose name was
bound anew to 127.0.0.1 (DNS rebinding) has its own name in ``Host``. Neither of them, nor another user of this
machine, knows the token in the path.
"""

import secrets
from collections.abc import Awaitable, Callable

from aiohttp import web

REPORT_PATH = "report"  # below the secret; a document, which may do nothing
DOWNLOAD = "/download/"  # the page asks for it by this name; what follows is a secret of its own
Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]


class Guard:
    """Refuses what does not come from this server's page; ``authority`` is its HOST:PORT as browsers say it."""

    def __init__(self, authority: str) -> None:
        self.authority = authority
        self.token = secrets.token_urlsafe(24)

    @property
    def url(self) -> str:
        """The address of the page."""
        return f"http://{self.authority}/{self.token}/"

    @property
    def report(self) -> str:
        """The path of the report."""
        return f"/{self.token}/{REPORT_PATH}"

    def fault(self, request: web.Request) -> str:
        """Return why a request is refused, empty if it is not."""
        own = f"http://{self.authority}"
        if (host := request.headers.get("Host", "")) != self.authority:
            return f"found Host {host!r}, expected {self.authority!r}"
        if (origin := request.headers.get("Origin", own)) != own:
            return f"found Origin {origin!r}, expected {own!r}"
        said = request.path.lstrip("/").partition("/")[0].encode()
        if request.path.startswith(DOWNLOAD) or secrets.compare_digest(said, self.token.encode()):
            return ""
        return "the address does not contain this server's secret"

    @web.middleware
    async def middleware(self, request: web.Request, handler: Handler) -> web.StreamResponse:
        """Answer 403 to what is refused."""
        if fault := self.fault(request):
            raise web.HTTPForbidden(text=f"{fault}; open the address that the station printed\n")
        return await handler(request)

    async def add_headers(self, request: web.Request, response: web.StreamResponse) -> None:
        """Have the browser ask nobody else, show the page in no other, and tell its address to nobody.

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
