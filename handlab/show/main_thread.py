"""Widget callbacks on the main thread, the newest first.

Current JupyterLab hands slider messages to the kernel on another thread. Drawing there turns pictures to noise or lets them stand
still, so callbacks are handed over to the event loop of the thread that made the widget; of a burst only the last one is run.
"""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from typing import Generic, TypeVar

T = TypeVar("T")


class OnMain(Generic[T]):
    """A callback of one value that always runs on the thread where it was made."""

    def __init__(self, callback: Callable[[T], None]) -> None:
        self._callback = callback
        self._home = threading.get_ident()
        self._lock = threading.Lock()
        self._waiting: list[T] = []
        try:
            self._loop: asyncio.AbstractEventLoop | None = asyncio.get_running_loop()
        except RuntimeError:
            self._loop = None  # a plain script: nothing else can call

    def __call__(self, value: T) -> None:
        """Run the callback here, or hand it over."""
        if threading.get_ident() == self._home or self._loop is None:
            self._callback(value)
            return
        with self._lock:
            first = not self._waiting
            self._waiting = [value]
        if first:
            self._loop.call_soon_threadsafe(self._run)

    def _run(self) -> None:
        with self._lock:
            waiting, self._waiting = self._waiting, []
        for value in waiting:
            self._callback(value)
