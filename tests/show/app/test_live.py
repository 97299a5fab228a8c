"""What a page is told while the soft skin is made ready."""

import asyncio
import time

import pytest

pytest.importorskip("wslink")
from handlab.show.app import live
from handlab.show.app.guard import Guard
from handlab.show.session import Session


class Slow(Session):
    """A hand whose soft skin takes some time, or fails."""

    seconds, trouble = 0.0, None

    def prepare(self):
        time.sleep(self.seconds)
        if self.trouble:
            raise self.trouble


@pytest.fixture
def told(hand, monkeypatch):
    """What all pages hear while a skin is prepared that takes ``seconds``, where 0.1 s are slow."""
    monkeypatch.setattr(live, "PREPARE_AFTER", 0.0)
    monkeypatch.setattr(live, "SLOW", 0.1)

    def run(seconds, trouble=None):
        heard = []
        host = live.Live(Guard(), heard.append, None)
        host.publish = lambda topic, reply, client_id=None: heard.append(reply)
        host.session = session = Slow(hand)
        session.seconds, session.trouble = seconds, trouble

        async def prepared():
            await host._prepare(session)
            await asyncio.sleep(0.2)  # and nothing is told afterwards

        asyncio.run(prepared())
        return [one["text"] if isinstance(one, dict) and one["kind"] == "answer" else one for one in heard]

    return run


def test_a_page_hears_that_the_soft_skin_takes_long_only_if_it_does(told):
    assert live.SOON not in told(0.0)
    assert told(0.3).count(live.SOON) == 1


def test_a_skin_that_fails_is_told_once_and_nothing_follows(told):
    heard = told(0.0, ValueError("no muscles"))
    assert heard == ["no soft skin: ValueError: no muscles", "no soft skin: no muscles"]
