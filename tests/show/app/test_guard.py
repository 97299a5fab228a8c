"""Who may talk to the server."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from handlab.show.app.guard import DATA, EVERYWHERE, LOOPBACK, TICKET_SECONDS, Guard, same_place, warning

HERE = "127.0.0.1:8765"


def test_a_page_of_our_own_with_the_key_is_let_through():
    guard = Guard()
    assert guard.objection(HERE, f"http://{HERE}", DATA + "scene", guard.key) is None
    assert guard.objection("localhost:9000", "http://localhost:9000", DATA + "scene", guard.key) is None  # through a tunnel
    assert guard.objection("[::1]:8765", "http://[::1]:8765", "/ws", None) is None  # the socket asks for the key itself


@pytest.mark.parametrize("key", [None, "", "wslink-secret", 7, b"bytes", ["list"]])
def test_data_without_the_key_is_refused(key):
    assert "key" in Guard().objection(HERE, None, DATA + "scene", key)


@given(st.text(max_size=60))
def test_no_other_text_is_the_key(text):
    guard = Guard(key="the-key-of-this-test")
    assert guard.knows(text) == (text == "the-key-of-this-test")


@pytest.mark.parametrize(
    "origin", ["https://evil.example", "http://127.0.0.1:9999", "null", "", "http://127.0.0.1", "file://127.0.0.1:8765", "http://["]
)
def test_a_page_from_elsewhere_is_refused_even_with_the_key(origin):
    guard = Guard()
    assert "elsewhere" in guard.objection(HERE, origin, DATA + "scene", guard.key)
    assert "elsewhere" in guard.objection(HERE, origin, "/ws", None)


@pytest.mark.parametrize("host", ["evil.example", "evil.example:8765", "127.0.0.1.evil.example", "", "[", "10.0.0.1:8765"])
def test_a_name_that_was_pointed_at_this_computer_is_refused(host):
    guard = Guard()
    assert "this computer only" in guard.objection(host, f"http://{host}", DATA + "scene", guard.key)


@given(st.text(max_size=40), st.text(max_size=40))
def test_strange_headers_are_answered_and_never_raise(host, origin):
    guard = Guard()
    assert guard.objection(host, origin, DATA, "wrong") is not None
    assert isinstance(same_place(origin, host), bool)


def test_listening_for_others_keeps_key_and_origin():
    guard = Guard(host="0.0.0.0")
    assert guard.objection("lab-7:8765", "http://lab-7:8765", DATA, guard.key) is None
    assert "key" in guard.objection("lab-7:8765", None, DATA, "guess")
    assert "elsewhere" in guard.objection("lab-7:8765", "http://evil.example", DATA, guard.key)


def test_keys_differ_and_are_long():
    keys = {Guard().key for _ in range(100)}
    assert len(keys) == 100
    assert min(map(len, keys)) >= 32


def test_a_ticket_opens_the_page_once_and_within_a_minute(monkeypatch):
    guard = Guard()
    ticket, late = guard.ticket(), guard.ticket()
    assert guard.redeem(ticket)
    assert not guard.redeem(ticket)
    assert not guard.redeem("guess")
    assert not guard.redeem(None)
    import time

    now = time.monotonic()
    monkeypatch.setattr(time, "monotonic", lambda: now + TICKET_SECONDS + 1.0)
    assert not guard.redeem(late)


def test_only_other_networks_bring_a_warning():
    assert all(warning(host) is None for host in LOOPBACK)
    for host in (*EVERYWHERE, "192.168.1.7"):
        assert "key" in warning(host)
        assert "not encrypted" in warning(host)
