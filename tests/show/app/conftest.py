"""A server as the command starts it, in a process of its own, and a page that speaks to it without a browser."""

import asyncio
import contextlib
import http.client
import os
import re
import signal
import struct
import subprocess
import sys
import time
from pathlib import Path
from urllib.parse import parse_qs, urlsplit

import pytest

PATIENCE = 60.0


class Served:
    """``handlab`` on a free port: ``host``, ``port``, ``key``, ``address``; ``said`` is what it printed."""

    def __init__(self, *arguments, **environment):
        line = [sys.executable, "-m", "handlab.cli", *arguments, "--port", "0", "--no-browser"]
        self.started = time.perf_counter()
        self.process = subprocess.Popen(
            line, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, env={**os.environ, **environment}, start_new_session=True
        )
        self.said = []
        while True:
            self.said.append(self.process.stdout.readline())
            found = re.search(r"http://\S+", self.said[-1])
            if found:
                break
            assert self.said[-1], "".join(self.said)
        self.address = found.group(0)
        parts = urlsplit(self.address)
        self.host, self.port, self.key = parts.hostname, parts.port, parse_qs(parts.query)["secret"][0]

    def get(self, path, *, host=None, key=None, **headers):
        """Status, headers and body of a request, with any ``Host`` and without following redirections."""
        line = http.client.HTTPConnection(self.host, self.port, timeout=PATIENCE)
        try:
            line.putrequest("GET", path, skip_host=True)
            line.putheader("Host", host or f"{self.host}:{self.port}")
            for name, value in {**headers, **({"X-Handlab-Key": key} if key else {})}.items():
                line.putheader(name.replace("_", "-"), value)
            line.endheaders()
            answer = line.getresponse()
            return answer.status, dict(answer.getheaders()), answer.read()
        finally:
            line.close()

    def alive(self):
        """Whether the server still gives the hand to who has the key."""
        return self.process.poll() is None and self.get("/handlab/data/scene", key=self.key)[0] == 200

    def cpu(self):
        """Seconds of processor time that the server has used."""
        fields = Path(f"/proc/{self.process.pid}/stat").read_text().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def stop(self):
        """Ctrl-C; its exit code."""
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
        try:
            rest, _ = self.process.communicate(timeout=20)
        except subprocess.TimeoutExpired:
            self.process.kill()
            raise
        self.said.append(rest)
        return self.process.returncode


class Page:
    """What a page does, without a browser: ``frames`` (bytes) and ``notes`` (dicts) as they arrived.

    ``draws``: give the credit for every frame back, as a page that draws does.
    """

    def __init__(self, socket, draws):
        self.socket, self.looking, self.draws = socket, None, draws
        self.frames, self.notes, self.answers = [], [], {}
        self.calls = 0
        self.name = "c0"
        self.reader = asyncio.ensure_future(self._read())

    async def _read(self):
        import msgpack

        parts = {}
        async for message in self.socket:
            number, _, size = struct.unpack("<III", message.data[:12])
            parts[number] = parts.get(number, b"") + message.data[12:]
            if len(parts[number]) < size:
                continue
            content = msgpack.unpackb(parts.pop(number))
            kind, *rest = content["id"].split(":")
            if kind == "publish" and rest[0] == "handlab.note":
                self.notes.append(content["result"])
            else:
                self.answers[content["id"]] = content

    async def look(self, socket):
        """Take frames from a socket of their own."""
        self.looking, self.looker = socket, asyncio.ensure_future(self._look())

    async def _look(self):
        async for message in self.looking:
            self.frames.append(message.data)
            if self.draws:
                with contextlib.suppress(ConnectionError):  # the test is over
                    await self.drawn()

    async def drawn(self):
        """A frame was drawn."""
        await self.looking.send_str("drawn")

    async def call(self, method, *arguments, system=False):
        """Send a call and return the word under which its answer comes."""
        import msgpack

        self.calls += 1
        word = "system:c0:0" if system else f"rpc:{self.name}:{self.calls}"
        body = msgpack.packb({"wslink": "1.0", "id": word, "method": method, "args": list(arguments), "kwargs": {}})
        await self.socket.send_bytes(struct.pack("<III", self.calls, 0, len(body)) + body)
        return word

    async def answer(self, method, *arguments, system=False):
        """Call and wait for the answer."""
        word = await self.call(method, *arguments, system=system)
        await self.until(lambda: word in self.answers)
        return self.answers[word]

    async def send(self, message):
        """A message of the viewer."""
        await self.call("handlab.message", message)

    async def until(self, condition, seconds=PATIENCE):
        """Wait for a condition."""
        end = time.perf_counter() + seconds
        while not condition():
            assert time.perf_counter() < end, f"waited {seconds} s; notes: {self.notes[-3:]}, {len(self.frames)} frames"
            await asyncio.sleep(0.005)


async def joined(http_session, served, *, draws=True, key=None, **headers):
    """A page that has said hello and asked for frames."""
    socket = await http_session.ws_connect(f"ws://{served.host}:{served.port}/ws", headers=headers)
    page = Page(socket, draws)
    hello = await page.answer("wslink.hello", {"secret": key or served.key}, system=True)
    if "result" in hello:
        page.name = hello["result"]["clientID"]
        served.get("/handlab/data/scene", key=served.key)
        address = f"ws://{served.host}:{served.port}/handlab/data/frames?secret={served.key}"
        await page.look(await http_session.ws_connect(address, headers=headers))
        await page.until(lambda: page.frames)
    page.hello = hello
    return page


def talk(work):
    """Run ``work(http_session)`` on a loop of its own."""
    import aiohttp

    async def main():
        async with aiohttp.ClientSession() as http_session:
            return await asyncio.wait_for(work(http_session), 2 * PATIENCE)

    return asyncio.run(main())


@pytest.fixture(scope="module")
def served():
    """One server for the tests of a module; it must end with code 0 on Ctrl-C."""
    server = Served()
    yield server
    assert server.stop() == 0, "".join(server.said)


@pytest.fixture
def join():
    """``joined``: tests are imported one by one, so that they get it from here."""
    return joined


@pytest.fixture
def converse():
    """``talk``."""
    return talk


@pytest.fixture
def serve():
    """Start a server with arguments and environment of one's own."""
    begun = []

    def start(*arguments, **environment):
        begun.append(Served(*arguments, **environment))
        return begun[-1]

    yield start
    for server in begun:
        server.stop()
