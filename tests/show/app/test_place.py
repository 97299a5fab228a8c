"""Ports, hosts and browsers that are not there."""

import os
import socket
import webbrowser

import pytest

from handlab.show.app import place


def test_a_free_port_is_taken_as_it_is_and_the_next_one_if_it_is_not():
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        taken = other.getsockname()[1]
        got = place.free_port("127.0.0.1", taken)
        assert taken < got < taken + place.TRIES
    assert place.free_port("127.0.0.1", got) == got


def test_port_zero_gives_any_port():
    assert place.free_port("127.0.0.1", 0) > 0


@pytest.mark.parametrize(("host", "words"), [("198.51.100.7", "no address of this computer"), ("no-such-host.invalid", "there is no host")])
def test_a_host_that_is_not_this_computer_is_told_in_one_sentence(host, words):
    with pytest.raises(OSError, match=words):
        place.free_port(host, 0)


@pytest.mark.parametrize("port", [-1, 65536])
def test_a_port_is_a_port(port):
    with pytest.raises(ValueError, match="65535"):
        place.checked_port(port)


def test_without_a_screen_no_browser_is_started(monkeypatch):
    monkeypatch.delenv("CI", raising=False)
    monkeypatch.delenv("BROWSER", raising=False)
    monkeypatch.setattr(place, "screen", lambda: False)
    monkeypatch.setattr(webbrowser, "open", lambda _: pytest.fail("a browser was started"))
    assert "open the address" in place.open_page("http://127.0.0.1:1/")


@pytest.mark.parametrize("found", [False, webbrowser.Error("could not locate runnable browser")])
def test_a_missing_browser_is_told_in_one_sentence(monkeypatch, found):
    def answer(_):
        if isinstance(found, Exception):
            raise found
        return found

    monkeypatch.delenv("CI", raising=False)
    monkeypatch.setattr(place, "screen", lambda: True)
    monkeypatch.setattr(webbrowser, "open", answer)
    assert place.open_page("http://127.0.0.1:1/").startswith("no browser could be started")


def test_the_launchers_own_complaints_stay_off_the_terminal(capfd):
    with place.quiet():
        os.write(2, b"a launcher complains")
    os.write(2, b"we speak")
    assert capfd.readouterr().err == "we speak"
