"""Who may ask the studio: only the page at the address that it printed."""

import base64
import json
import re
import socket
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
    assert studio.ask(f"{place}favicon.ico", Cookie=given.partition(";")[0]).status == 200
    assert "bokeh" in page.text
    policy = page.headers["Content-Security-Policy"]
    assert "default-src 'self'" in policy
    assert "frame-ancestors 'none'" in policy
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
    for path in ("/", "/ws", "/static/js/bokeh.min.js", "/favicon.ico", f"/{studio.place[2:]}A/", studio.place):
        assert studio.ask(path, Cookie=studio.cookie).status == 403, path
        assert studio.ask(path, **UPGRADE, Cookie=studio.cookie).status == 403, path
    for path in ("/", "/ws", "/static/js/bokeh.min.js"):
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
        (f"{place}/static/js/bokeh.min.js", {}),
        (f"{place}/ws?token={token}", UPGRADE),
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


def session_token(studio):
    page = studio.ask(f"{studio.place}/", Cookie=studio.cookie).text
    return re.search(r'"token":\s*"([^"]+)"', page)[1]


def test_a_web_socket_of_our_own_page_passes(studio):
    given = {"Origin": f"http://127.0.0.1:{studio.port}", "Cookie": studio.cookie}
    given["Sec_WebSocket_Protocol"] = f"bokeh, {session_token(studio)}"
    assert studio.ask(f"{studio.place}/ws", **UPGRADE, **given).status == 101


@pytest.mark.parametrize(
    "protocol",
    ["bokeh", "bokeh, x", "bokeh, e30", "other, {token}", "bokeh, {token}x.y", "bokeh, !!!", "bokeh, W10", ""],
)
def test_a_web_socket_without_the_token_of_a_session_is_refused(studio, protocol):
    given = {"Origin": f"http://127.0.0.1:{studio.port}", "Cookie": studio.cookie}
    given["Sec_WebSocket_Protocol"] = protocol.format(token=session_token(studio))
    assert studio.ask(f"{studio.place}/ws", **UPGRADE, **given).status == 403


@pytest.mark.parametrize("session", [[1], None, "", 5, {"a": 1}])
def test_a_web_socket_whose_session_has_no_name_is_refused(studio, session):
    payload = json.dumps({"session_id": session, "session_expiry": 10**10}).encode()
    token = base64.urlsafe_b64encode(payload).decode().rstrip("=")
    given = {"Origin": f"http://127.0.0.1:{studio.port}", "Cookie": studio.cookie}
    given["Sec_WebSocket_Protocol"] = f"bokeh, {token}"
    assert studio.ask(f"{studio.place}/ws", **UPGRADE, **given).status == 403


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
