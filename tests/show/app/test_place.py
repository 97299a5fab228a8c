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


@pytest.fixture
def begin(monkeypatch):
    """``start`` without serving: what it says, and the addresses that it opens."""
    from handlab.show.app import server

    async def run(app, *, opened):
        opened(app)

    monkeypatch.setattr(server.App, "run", run)
    addresses = []
    monkeypatch.setattr(server, "open_page", addresses.append)

    def start(**how):
        said = []
        server.start(lambda: None, **{"host": "127.0.0.1", "port": 0, "browser": True, "say": said.append, **how})
        return "\n".join(said), addresses

    return start


def test_a_taken_port_is_told_and_worked_round(begin):
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        port = other.getsockname()[1]
        said, addresses = begin(port=port)
    assert said.startswith(f"Port {port} is taken; using ")
    assert f":{port}/" not in said.partition("\n")[2]
    assert len(addresses) == 1


def test_the_browser_is_given_a_ticket_and_never_the_key(begin):
    said, (address,) = begin()
    key = said.partition("secret=")[2].split()[0]
    assert len(key) >= 32
    assert key not in address
    assert "ticket=" in address


def test_other_networks_bring_the_warning_before_the_address(begin, capsys):
    said, _ = begin(host="0.0.0.0", browser=False)
    assert "not encrypted" in capsys.readouterr().err
    assert "http://127.0.0.1:" in said
    assert "this computer's name" in said


def test_no_browser_is_opened_when_none_is_wanted(begin):
    assert begin(browser=False)[1] == []
