"""Who may ask the studio: only the page at the address that it printed."""

import socket
from pathlib import Path

import pytest

UPGRADE = {
    "Upgrade": "websocket",
    "Connection": "Upgrade",
    "Sec_WebSocket_Version": "13",
    "Sec_WebSocket_Key": "dGhlIHNhbXBsZSBub25jZQ==",
}


def test_the_token_opens_the_page_once_and_a_cookie_after_that(studio):
    first = studio.ask(f"/?token={studio.token}")
    assert (first.status, first.headers["Location"]) == (303, "/")  # the address without the token
    given = first.headers["Set-Cookie"]
    assert "HttpOnly" in given
    assert "SameSite=Strict" in given
    assert studio.token not in given
    page = studio.ask("/", Cookie=given.partition(";")[0])
    assert page.status == 200
    assert "bokeh" in page.text
    policy = page.headers["Content-Security-Policy"]
    assert "default-src 'self'" in policy
    assert "frame-ancestors 'none'" in policy
    assert "http" not in policy.replace(f"ws://127.0.0.1:{studio.port}", "")  # nothing from elsewhere


def test_without_token_or_with_a_wrong_one_nothing_is_answered(studio):
    wrong = studio.token[:-1] + ("A" if studio.token[-1] != "A" else "B")
    name = studio.cookie().partition("=")[0]
    for path, headers in (
        ("/", {}),
        (f"/?token={wrong}", {}),
        ("/?token=", {}),
        (f"/?token={wrong}&token={studio.token}", {}),
        ("/", {"Cookie": f"{name}={studio.token}"}),
        ("/", {"Cookie": f"{name}="}),
        ("/static/js/bokeh.min.js", {}),
        (f"/ws?token={studio.token}", UPGRADE),
        ("/favicon.ico", {}),
    ):
        answer = studio.ask(path, **headers)
        assert answer.status == 403, path
        assert len(answer.text) < 200
        assert "token" not in answer.text


@pytest.mark.parametrize(
    "host", ["evil.example:{port}", "evil.example", "127.0.0.1", "127.0.0.1:1", "localhost.evil:{port}", ""]
)
def test_a_name_that_only_leads_here_is_refused(studio, host):
    answer = studio.ask(f"/?token={studio.token}", Host=host.format(port=studio.port))
    assert answer.status == 403


def test_both_of_our_own_names_are_answered(studio):
    for host in ("127.0.0.1", "localhost", "LOCALHOST", "[::1]"):
        assert studio.ask("/", Host=f"{host}:{studio.port}", Cookie=studio.cookie()).status == 200


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
    given = {"Origin": origin.format(port=studio.port), "Cookie": studio.cookie()}
    assert studio.ask("/", **given).status == 403
    assert studio.ask("/ws", **UPGRADE, **given).status == 403


def test_a_web_socket_of_our_own_page_passes_the_guard(studio):
    given = {"Origin": f"http://127.0.0.1:{studio.port}", "Cookie": studio.cookie()}
    assert studio.ask("/ws", **UPGRADE, **given).status != 403  # Bokeh then asks for the token of a session


def test_other_pages_may_link_here_but_not_load_from_here(studio):
    cookie = studio.cookie()
    visit = {"Sec_Fetch_Site": "cross-site", "Sec_Fetch_Mode": "navigate", "Sec_Fetch_Dest": "document"}
    assert studio.ask(f"/?token={studio.token}", **visit).status == 200
    assert studio.ask("/", Cookie=cookie, Sec_Fetch_Site="cross-site", Sec_Fetch_Mode="no-cors").status == 403
    assert studio.ask("/", Cookie=cookie, **{**visit, "Sec_Fetch_Dest": "iframe"}).status == 403


@pytest.mark.parametrize(
    "path",
    [
        "/../m.toml",
        "/static/../../m.toml",
        "/static/%2e%2e/%2e%2e/m.toml",
        "/static/%252e%252e/x",
        "//etc/passwd",
        "/m.toml",
        "/static/..\\..\\m.toml",
        "/static/extensions/panel/../../../../m.toml",
        "/autoload.js",
        "/metadata",
        "/static/%00",
    ],
)
def test_paths_that_lead_elsewhere_are_refused(studio, path):
    answer = studio.ask(path, Cookie=studio.cookie())
    assert answer.status == 403
    assert "pendulum" not in answer.text


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "OPTIONS", "CONNECT"])
def test_only_reading_is_asked_for_by_http(studio, method):
    assert studio.ask("/", method, Cookie=studio.cookie()).status == 403


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
