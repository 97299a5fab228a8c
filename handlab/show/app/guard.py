"""Who may talk to the server: pages that it served itself, to clients that know its key.

A server on 127.0.0.1 is within reach of every page that the user has open, and of every other user of the machine. So every
request must carry a ``Host`` that is this computer (a page elsewhere could have its name point here), an ``Origin``, where a
browser sends one, that is the same place, and, for anything but the program text of the page, the random key of this run.
"""

from __future__ import annotations

import hmac
import secrets
import time
from collections.abc import Awaitable, Callable
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

if TYPE_CHECKING:
    from aiohttp.web import Request, StreamResponse

    Handler = Callable[[Request], Awaitable[StreamResponse]]

KEY_BYTES = 24
TICKET_SECONDS = 60.0
LOOPBACK = frozenset({"127.0.0.1", "localhost", "::1"})
EVERYWHERE = frozenset({"0.0.0.0", "::", ""})
DATA = "/handlab/data/"  # below here everything needs the key in the request itself; the socket asks for it in its first message
HEADERS = {
    "Cache-Control": "no-cache",
    "Referrer-Policy": "no-referrer",  # the address holds the key
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "SAMEORIGIN",
    "Cross-Origin-Resource-Policy": "same-origin",
    # trame's page compiles its templates when it loads: 'unsafe-eval'. Nothing from elsewhere, and nothing sent elsewhere.
    "Content-Security-Policy": (
        "default-src 'self'; script-src 'self' 'unsafe-inline' 'unsafe-eval'; style-src 'self' 'unsafe-inline'; "
        "img-src 'self' data: blob:; media-src 'self' blob:; connect-src 'self' ws: wss: data: blob:; "
        "frame-ancestors 'self'; base-uri 'self'"
    ),
}


class Guard:
    """The key of one run, and the check of every request against it.

    ``host`` is the address that the server binds to; with any but a loopback address the ``Host`` of a request cannot be known
    beforehand, and key and ``Origin`` remain.
    """

    def __init__(self, host: str = "127.0.0.1", key: str | None = None) -> None:
        self.key = key or secrets.token_urlsafe(KEY_BYTES)
        self.local = host in LOOPBACK
        self._tickets: dict[str, float] = {}

    def knows(self, key: object) -> bool:
        """Whether ``key`` is the key; as slow for a nearly right one as for a wrong one."""
        return isinstance(key, str) and hmac.compare_digest(key.encode(), self.key.encode())

    def ticket(self) -> str:
        """A word that opens the page once, within a minute: what stands in the command line of a browser can be read by others."""
        word = secrets.token_urlsafe(KEY_BYTES)
        self._tickets[word] = time.monotonic() + TICKET_SECONDS
        return word

    def redeem(self, word: object) -> bool:
        """Whether ``word`` is a ticket that nobody used before."""
        end = self._tickets.pop(word, None) if isinstance(word, str) else None
        return end is not None and time.monotonic() <= end

    def objection(self, host: str, origin: str | None, path: str, key: object) -> str | None:
        """Why a request is refused, in one sentence; ``None`` if it is not.

        ``host`` and ``origin`` are the headers, ``path`` the path of the address, ``key`` what came as the key.
        """
        name = hostname(host)
        if self.local and name not in LOOPBACK:
            return f"this server answers on this computer only, not as {name!r}"
        if origin is not None and not same_place(origin, host):
            return "a page from elsewhere must not use this hand"
        if path.startswith(DATA) and not self.knows(key):
            return "the key is missing or wrong; open the address that handlab printed"
        return None

    async def answer(self, request: Request, handler: Handler) -> StreamResponse:
        """Refuse a request, or let it through and add headers."""
        from aiohttp import web

        key = request.headers.get("X-Handlab-Key") or request.query.get("secret")
        why = self.objection(request.headers.get("Host", ""), request.headers.get("Origin"), request.path, key)
        if why is not None:
            return web.Response(status=403, text=f"handlab: {why}.\n", headers=HEADERS)
        try:
            response = await handler(request)
        except web.HTTPException as answer:
            answer.headers.update(HEADERS)
            raise
        if not response.prepared:  # a socket has answered already
            for name, value in HEADERS.items():
                response.headers.setdefault(name, value)
        return response


def hostname(host: str) -> str:
    """The name in a ``Host`` header, without port and brackets, in small letters."""
    try:
        return (urlsplit(f"//{host}").hostname or "").lower()
    except ValueError:
        return ""


def same_place(origin: str, host: str) -> bool:
    """Whether a page of ``origin`` came from the server that ``host`` names, port and all."""
    try:
        return urlsplit(origin).netloc.lower() == host.lower() and urlsplit(origin).scheme in ("http", "https")
    except ValueError:
        return False


def warning(host: str) -> str | None:
    """What the user must know before the server listens on ``host``; ``None`` for this computer alone."""
    if host in LOOPBACK:
        return None
    where = "every network of this computer" if host in EVERYWHERE else host
    return (
        f"warning: listening on {where}. Everyone who gets the address with its key moves this hand, "
        "and the connection is not encrypted; over networks that you do not trust use an SSH tunnel instead."
    )
