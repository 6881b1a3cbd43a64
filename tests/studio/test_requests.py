"""Who may ask the studio: only the page at the address that it printed."""

import json
import socket
import threading
import time
from pathlib import Path

import pytest

UPGRADE = {
    "Upgrade": "websocket",
    "Connection": "Upgrade",
    "Sec_WebSocket_Version": "13",
    "Sec_WebSocket_Key": "dGhlIHNhbXBsZSBub25jZQ==",
}


def test_a_token_opens_the_page_once_and_a_cookie_of_its_place_after_that(studio):
    token = studio.new_token()
    first = studio.ask(f"/?token={token}")
    assert first.status == 303
    place, given = first.headers["Location"], first.headers["Set-Cookie"]
    assert len(place) > 40  # nobody guesses it
    assert "HttpOnly" in given
    assert "SameSite=Strict" in given
    assert f"Path={place};" in given
    assert token not in given + place
    page = studio.ask(place, Cookie=given.partition(";")[0])
    assert page.status == 200
    assert studio.ask(f"{place}icon.svg", Cookie=given.partition(";")[0]).status == 200
    assert 'src="main.js"' in page.text
    assert page.headers["Cache-Control"] == "no-store"
    assert page.headers["Referrer-Policy"] == "no-referrer"
    assert page.headers["X-Content-Type-Options"] == "nosniff"
    assert page.headers["Set-Cookie"] is None
    policy = page.headers["Content-Security-Policy"]
    assert "default-src 'self'" in policy
    assert "frame-ancestors 'none'" in policy
    assert "script-src 'self' 'unsafe-eval' blob:;" in policy  # no scripts inside of pages, none from elsewhere
    assert "http" not in policy.replace(f"ws://127.0.0.1:{studio.port}", "")  # nothing from elsewhere
    again = studio.ask(f"/?token={token}")
    assert again.status == 403
    assert "press Enter in the terminal" in again.text  # how to get another


@pytest.mark.parametrize(
    "around",
    [
        "theme=dark mode; {}",
        "novalue; {}",
        "{}; novalue",
        "{}; {name}=of-another-port",
        "{name}=of-another-port; {}",
        '{name}="; {}; x="',
        "bad[]name=1;{} ;;",
    ],
)
def test_cookies_of_other_ports_do_not_lock_the_page_out(studio, around):
    """Cookies do not know ports: whatever another page of this computer sets is sent to ours too."""
    name = studio.cookie.partition("=")[0]
    sent = around.format(studio.cookie, name=name)
    assert studio.ask(f"{studio.place}/", Cookie=sent).status == 200
    assert studio.ask(f"{studio.place}/", Cookie=sent.replace(studio.cookie, f"{studio.cookie}x")).status == 403


def test_looking_ahead_does_not_spend_the_token(studio):
    token = studio.new_token()
    assert studio.ask(f"/?token={token}", "HEAD").status == 403
    assert studio.ask(f"/?token={token}", Sec_Purpose="prefetch;prerender").status == 403
    assert studio.ask(f"/?token={token}").status == 303


def test_the_cookie_is_of_no_use_without_the_place_nor_the_place_without_the_cookie(studio):
    """What another program learns from one of them, such as a page of another port that is sent the cookie."""
    for path in ("/", "/ws", "/main.js", "/icon.svg", f"/{studio.place[2:]}A/", studio.place):
        assert studio.ask(path, Cookie=studio.cookie).status == 403, path
        assert studio.ask(path, **UPGRADE, Cookie=studio.cookie).status == 403, path
    for path in ("/", "/ws", "/main.js"):
        assert studio.ask(studio.place + path).status == 403, path


def test_without_token_or_with_a_wrong_one_nothing_is_answered(studio):
    token, (place, cookie) = studio.new_token(), studio.entered
    wrong = token[:-1] + ("A" if token[-1] != "A" else "B")
    name = cookie.partition("=")[0]
    for path, headers in (
        ("/", {}),
        (f"/?token={wrong}", {}),
        ("/?token=", {}),
        (f"/?token={wrong}&token={token}", {}),
        (f"{place}/?token={token}", {}),
        (f"{place}/", {"Cookie": f"{name}={token}"}),
        (f"{place}/", {"Cookie": f"{name}="}),
        (f"{place}/main.js", {}),
        (f"{place}/ws?token={token}", UPGRADE),
        ("/icon.svg", {}),
    ):
        answer = studio.ask(path, **headers)
        assert answer.status == 403, path
        assert len(answer.text) < 200
        assert "token" not in answer.text


@pytest.mark.parametrize(
    "host", ["evil.example:{port}", "evil.example", "127.0.0.1", "127.0.0.1:1", "localhost.evil:{port}", ""]
)
def test_a_name_that_only_leads_here_is_refused(studio, host):
    answer = studio.ask(f"/?token={studio.new_token()}", Host=host.format(port=studio.port))
    assert answer.status == 403


def test_both_of_our_own_names_are_answered(studio):
    for host in ("127.0.0.1", "localhost", "LOCALHOST", "[::1]"):
        assert studio.ask(f"{studio.place}/", Host=f"{host}:{studio.port}", Cookie=studio.cookie).status == 200


@pytest.mark.parametrize(
    "origin",
    [
        "http://evil.example",
        "http://127.0.0.1:1",
        "https://127.0.0.1:{port}",
        "null",
        "http://127.0.0.1:{port}.evil.example",
    ],
)
def test_another_origin_is_refused_pages_and_web_sockets(studio, origin):
    given = {"Origin": origin.format(port=studio.port), "Cookie": studio.cookie}
    assert studio.ask(f"{studio.place}/", **given).status == 403
    assert studio.ask(f"{studio.place}/ws", **UPGRADE, **given).status == 403


def test_a_web_socket_of_our_own_page_passes(studio):
    given = {"Origin": f"http://127.0.0.1:{studio.port}", "Cookie": studio.cookie}
    assert studio.ask(f"{studio.place}/ws", **UPGRADE, **given).status == 101


def test_a_web_socket_without_the_page_it_comes_from_is_refused(studio):
    assert studio.ask(f"{studio.place}/ws", **UPGRADE, Cookie=studio.cookie).status == 403


def test_pages_are_no_web_sockets_and_the_web_socket_is_no_page(studio):
    given = {"Origin": f"http://127.0.0.1:{studio.port}", "Cookie": studio.cookie}
    assert studio.ask(f"{studio.place}/", **UPGRADE, **given).status == 403
    assert studio.ask(f"{studio.place}/ws", **given).status == 403


@pytest.mark.parametrize("where", ["iframe", "frame", "object", "embed"])
@pytest.mark.parametrize("site", ["same-origin", "same-site", "cross-site", "none"])
def test_the_page_is_not_shown_inside_of_another(studio, where, site):
    inside = {"Sec_Fetch_Site": site, "Sec_Fetch_Mode": "navigate", "Sec_Fetch_Dest": where}
    assert studio.ask(f"{studio.place}/", Cookie=studio.cookie, **inside).status == 403
    assert studio.ask(f"/?token={studio.new_token()}", **inside).status == 403


def test_other_pages_may_link_here_but_not_load_from_here(studio):
    cookie = studio.cookie
    visit = {"Sec_Fetch_Site": "cross-site", "Sec_Fetch_Mode": "navigate", "Sec_Fetch_Dest": "document"}
    assert studio.ask(f"/?token={studio.new_token()}", **visit).status == 200
    assert (
        studio.ask(f"{studio.place}/", Cookie=cookie, Sec_Fetch_Site="cross-site", Sec_Fetch_Mode="no-cors").status
        == 403
    )
    assert studio.ask(f"{studio.place}/", Cookie=cookie, **{**visit, "Sec_Fetch_Dest": "iframe"}).status == 403


@pytest.mark.parametrize(
    "path",
    [
        "/../m.toml",
        "/main.js/../../m.toml",
        "/%2e%2e/m.toml",
        "/%252e%252e/x",
        "/main%2ejs",
        "//etc/passwd",
        "/m.toml",
        "/..\\..\\m.toml",
        "/studio.html",
        "/main.js/",
        "/%00",
    ],
)
def test_paths_that_lead_elsewhere_are_refused(studio, path):
    answer = studio.ask(studio.place + path, Cookie=studio.cookie)
    assert answer.status == 403
    assert "pendulum" not in answer.text


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "OPTIONS", "CONNECT"])
def test_only_reading_is_asked_for_by_http(studio, method):
    assert studio.ask(f"{studio.place}/", method, Cookie=studio.cookie).status == 403


@pytest.mark.skipif(not Path("/proc/net/tcp").exists(), reason="who listens is read in /proc")
def test_nothing_listens_but_on_the_loopback(studio):
    ours = f":{studio.port:04X}"
    rows = [row.split() for table in ("tcp", "tcp6") for row in Path(f"/proc/net/{table}").read_text().splitlines()[1:]]
    listening = [row[1] for row in rows if row[1].endswith(ours) and row[3] == "0A"]
    assert listening == [f"0100007F{ours}"]  # 127.0.0.1, lowest byte first


def test_a_header_that_does_not_end_is_cut_off(studio):
    with socket.create_connection(("127.0.0.1", studio.port), timeout=10) as raw:
        raw.sendall(b"GET / HTTP/1.1\r\nHost: x\r\nX: " + b"a" * 200_000)
        raw.settimeout(10)
        try:
            answer = raw.recv(1000)
        except ConnectionResetError:
            answer = b""
        assert answer == b"" or b"400" in answer[:20]


def test_what_a_request_carries_is_not_read(studio):
    given = {"Cookie": studio.cookie, "Content_Length": "1000000000"}
    assert studio.ask(f"{studio.place}/", **given).status == 403
    given = {"Cookie": studio.cookie, "Transfer_Encoding": "chunked"}
    assert studio.ask(f"{studio.place}/", **given).status == 403


def test_a_studio_behind_its_names_alone_is_what_proxies_say_it_is_not(studio):
    """A program of this computer may claim to pass on what another asks for: it changes nothing."""
    given = {"X_Forwarded_For": "10.0.0.1", "X_Forwarded_Proto": "https", "X_Forwarded_Host": "evil.example"}
    assert studio.ask(f"{studio.place}/", Cookie=studio.cookie, **given).status == 200


@pytest.mark.parametrize("begun", [b"", b"GET / HTTP/1.1\r\nHost: x\r\n"])
def test_a_connection_that_never_ends_to_ask_is_closed(monkeypatch, begun):
    """Also one that sends another header now and then."""
    server = pytest.importorskip("rattle.studio.server")
    monkeypatch.setattr(server, "IDLE", 1)
    served = server.Server(None, ())
    thread = threading.Thread(target=served.run, args=(False, lambda: None))
    thread.start()
    end = time.monotonic() + 60
    with socket.create_connection(("127.0.0.1", served.port), timeout=0.3) as raw:
        raw.sendall(begun)
        while time.monotonic() < end:
            try:
                assert raw.recv(1000) == b""
                break
            except TimeoutError:
                raw.sendall(b"X: a\r\n" if begun else b"")
    served.uvicorn.should_exit = True
    thread.join()
    assert time.monotonic() < end


class Spoken:
    """A web socket to the studio as another program would open it: texts in frames."""

    def __init__(self, studio):
        self.raw = socket.create_connection(("127.0.0.1", studio.port), timeout=20)
        head = {
            "Host": f"127.0.0.1:{studio.port}", "Cookie": studio.cookie, "Origin": f"http://127.0.0.1:{studio.port}",
            **{name.replace("_", "-"): value for name, value in UPGRADE.items()},
        }  # fmt: skip
        lines = [f"GET {studio.place}/ws HTTP/1.1", *(f"{name}: {value}" for name, value in head.items())]
        self.raw.sendall("\r\n".join([*lines, "", ""]).encode())
        self.stream = self.raw.makefile("rb")
        assert b" 101 " in self.stream.readline()
        while self.stream.readline().strip():
            pass

    def send(self, content, kind=1):
        """One frame, with a mask of zeros."""
        size = len(content).to_bytes(8, "big")
        self.raw.sendall(bytes([0x80 | kind, 0x80 | 127]) + size + bytes(4) + content)

    def hear(self):
        """The next message, or the code with which the studio has closed."""
        while True:
            first, size = self.stream.read(2)
            size = int.from_bytes(self.stream.read({126: 2, 127: 8}[size]), "big") if size > 125 else size
            content = self.stream.read(size)
            if first & 15 == 8:
                return int.from_bytes(content[:2], "big")
            if first & 15 == 1:
                return json.loads(content)


def test_half_a_character_in_the_text_does_not_end_the_session(studio):
    spoken = Spoken(studio)
    spoken.send(json.dumps({"do": "text", "text": "name = '\ud800'"}).encode())
    spoken.send(json.dumps({"do": "hello"}).encode())
    heard = [spoken.hear() for _ in range(3)]
    assert {"kind": "text", "text": "name = '\ud800'", "fresh": False, "act": 0, "heard": 0} in heard


@pytest.mark.parametrize("nonsense", [b"", b"{", b"[" * 100_000, b'"text"', b"[1]", b'{"do": 1}', b'{"do": "no-such"}'])
def test_a_message_that_makes_no_sense_is_answered_and_the_session_goes_on(studio, nonsense):
    spoken = Spoken(studio)
    spoken.send(nonsense)
    assert spoken.hear()["kind"] == "trouble"
    spoken.send(nonsense, kind=2)
    assert spoken.hear()["kind"] == "trouble"
    spoken.send(b'{"do": "alive"}')
    assert spoken.hear() == {"kind": "alive"}
    spoken.raw.close()


def test_a_message_that_is_far_too_long_ends_its_session(studio):
    spoken = Spoken(studio)
    spoken.raw.sendall(bytes([0x81, 0x80 | 127]) + (10**10).to_bytes(8, "big") + bytes(4))
    assert spoken.hear() == 1009
    spoken.raw.close()
