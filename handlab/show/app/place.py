"""Where the server listens, and how its page gets into a browser."""

from __future__ import annotations

import errno
import os
import socket
import sys
import webbrowser
from contextlib import closing

from handlab.show.gl import screen

PORT = 8765
TRIES = 20
# A port that is in use or reserved. Windows has numbers of its own.
TAKEN = frozenset({errno.EADDRINUSE, errno.EACCES, getattr(errno, "WSAEADDRINUSE", -1), getattr(errno, "WSAEACCES", -1)})


def checked_port(port: int) -> int:
    """A port number, or ``ValueError``."""
    if not 0 <= port <= 65535:
        raise ValueError(f"port is {port}; it lies between 1 and 65535, or is 0 for any free one")
    return port


def free_port(host: str, wanted: int) -> int:
    """``wanted`` if nobody listens there, or the next free port after it; 0 asks the system for any.

    Raises ``OSError`` with what to do where the address does not belong to this computer, or no port near is free.
    """
    last: OSError | None = None
    for port in range(wanted, min(wanted + TRIES, 65536)):
        try:
            return bound(host, port)
        except socket.gaierror:
            raise OSError(f"there is no host {host!r}; --host takes an address of this computer, such as 127.0.0.1") from None
        except OSError as error:
            last = error
            if error.errno == errno.EADDRNOTAVAIL:
                raise OSError(f"{host} is no address of this computer; --host takes one that is, such as 127.0.0.1") from error
            if error.errno not in TAKEN:
                break
    why = "" if last is None or last.strerror is None else f" ({last.strerror.lower()})"
    raise OSError(f"cannot listen on {host}, port {wanted}{why}; choose another with --port, or let the system choose: --port 0") from last


def bound(host: str, port: int) -> int:
    """The port that a socket got; closed again."""
    family, kind, protocol, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE)[0]
    with closing(socket.socket(family, kind, protocol)) as probe:
        if os.name == "posix":  # a port that a server left a moment ago is free; on Windows this would share one in use
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        probe.bind(address)
        got: int = probe.getsockname()[1]
        return got


def shown_host(host: str) -> str:
    """The name of ``host`` in an address that this computer's own browser opens."""
    if host in ("0.0.0.0", "::", ""):
        return "127.0.0.1"
    return f"[{host}]" if ":" in host else host


def open_page(address: str) -> str | None:
    """Open an address in the user's browser; a sentence that says why not, where there is none."""
    paste = "open the address above in a browser"
    if "CI" in os.environ or not (screen() or "BROWSER" in os.environ):
        # Without a screen the system would start a browser for terminals inside this one.
        return f"no screen here: {paste}; from another computer, first: ssh -L PORT:127.0.0.1:PORT this-computer"
    try:
        with quiet():
            opened = webbrowser.open(address)
    except (webbrowser.Error, OSError) as error:
        return f"no browser could be started ({error}): {paste}"
    return None if opened else f"no browser could be started: {paste}"


class quiet:  # noqa: N801 (reads as a word)
    """Keep what a browser's launcher complains about off the terminal: its own streams are of no use to the user."""

    def __enter__(self) -> None:
        """Point the error stream of child processes to nowhere."""
        self._kept: int | None = None
        if os.name != "posix":
            return
        try:
            sys.stderr.flush()
            self._kept = os.dup(2)
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, 2)
            os.close(nowhere)
        except OSError:
            self._kept = None

    def __exit__(self, *_: object) -> None:
        """Put it back."""
        if self._kept is not None:
            os.dup2(self._kept, 2)
            os.close(self._kept)
