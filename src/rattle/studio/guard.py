"""Who may ask the studio: every request is checked here before anything else of the server sees it.

A request passes if it comes from the page that the studio itself has sent to the user who was given its address:

* `Host` is one of our own names with our port.  A foreign site whose name is made to lead to this computer (DNS
  rebinding) has its own name there.
* `Origin`, where a browser sends it, is our own page; `Sec-Fetch-Site` says the same of newer browsers.
* It knows the secrets: a token in the address, which is spent by its first use and exchanged for the place of the
  page, a path that nobody guesses, and for a cookie that scripts cannot read, that no other site makes the browser
  send, and that belongs to this path alone: what listens on other ports of this computer never gets it, though cookies
  do not know ports (RFC 6265, section 8.5).
* The path is one of the few that the page needs, plainly written.

Source: OWASP, Cross-Site Request Forgery Prevention Cheat Sheet; Jackson et al., Protecting browsers from DNS rebinding
attacks, ACM Transactions on the Web 3 (2009).
"""

from __future__ import annotations

import hmac
import secrets
import time
from collections.abc import Awaitable, Collection
from typing import Any
from urllib.parse import parse_qs, unquote, urlsplit

from bokeh.util.token import get_session_id, get_token_payload
from tornado.httputil import (
    HTTPHeaders,
    HTTPMessageDelegate,
    HTTPServerConnectionDelegate,
    RequestStartLine,
    ResponseStartLine,
)

METHODS = ("GET", "HEAD")  # the page asks for nothing else; all that changes anything goes over its web socket
ICON = "/favicon.ico"
PATHS = ("/", "/ws", ICON)  # below the place of the page
FOLDERS = ("/static/",)  # scripts of Bokeh and Panel
PLAIN = frozenset("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-._~/@+^")
LOOPBACK = ("127.0.0.1", "localhost", "[::1]")
FRAMES = ("iframe", "frame", "object", "embed", "fencedframe")  # the page is never part of another
ONWARD = '<!doctype html><title>rattle studio</title><meta http-equiv="refresh" content="0;url={}">'
REFUSED = (
    "403: this studio answers only its own page. Its address works once; press Enter in the terminal where"
    " `rattle studio` runs, and it prints a new one.\n"
)


class Secrets:
    """What a request has to know: a token of an address, and the place and cookie that it is exchanged for."""

    def __init__(self) -> None:
        self._tokens: set[str] = set()
        self.place = f"/{secrets.token_urlsafe(32)}"
        self.cookie = secrets.token_urlsafe(32)

    def issue(self) -> str:
        """A new token, good for one use."""
        token = secrets.token_urlsafe(32)
        self._tokens.add(token)
        return token

    def knows(self, token: str) -> bool:
        """True for a token that has not been used."""
        return any(_same(token, one) for one in self._tokens)

    def spend(self, token: str) -> None:
        """From now on this token is worth nothing."""
        self._tokens.discard(token)


class Guard(HTTPServerConnectionDelegate):
    """Passes requests on to `application` that may be answered, and refuses all others.

    hosts: names of this computer under which the studio may be reached.  port: ours.
    """

    def __init__(
        self, application: HTTPServerConnectionDelegate, keys: Secrets, hosts: Collection[str], port: int
    ) -> None:
        self.application, self.keys, self.port = application, keys, port
        self.hosts = {f"{host}:{port}".lower() for host in hosts}
        self.cookie_name = f"rattle-studio-{port}"

    def start_request(self, server_conn: object, request_conn: Any) -> HTTPMessageDelegate:
        """Watch one request; Tornado calls this."""
        return _Door(self, server_conn, request_conn)

    def on_close(self, server_conn: object) -> None:
        """A connection was closed; Tornado calls this."""
        self.application.on_close(server_conn)

    # ------------------------------------------------------------ the checks
    def why_not(self, start_line: RequestStartLine, headers: HTTPHeaders) -> str:
        """Why a request is refused, in a few words; "" if it may pass, or may have its token exchanged."""
        path, _, query = start_line.path.partition("?")
        below = self._below(path)
        if start_line.method not in METHODS:
            return "method"
        if path != "/" and not self._is_plain(below):
            return "path"
        hosts = headers.get_list("Host")
        if len(hosts) != 1 or hosts[0].strip().lower() not in self.hosts:
            return "host"
        if any(not self._is_ours(origin) for origin in headers.get_list("Origin")):
            return "origin"
        if headers.get("Sec-Fetch-Site", "none") not in ("none", "same-origin") and not self._is_visit(below, headers):
            return "origin"
        if headers.get("Sec-Fetch-Dest", "document") in FRAMES:
            return "frame"
        if path == "/":
            looks_ahead = start_line.method != "GET" or "Sec-Purpose" in headers  # which must not spend the token
            return "token" if looks_ahead or not self.token_of(path, query) else ""
        if not self._has_cookie(headers):
            return "cookie"
        return "session" if below == "/ws" and not _names_session(headers) else ""

    def token_of(self, path: str, query: str) -> str:
        """The token that the address of the page has, if it is worth something; "" otherwise."""
        given = parse_qs(query).get("token", [])
        return given[0] if path == "/" and len(given) == 1 and self.keys.knows(given[0]) else ""

    def _below(self, path: str) -> str:
        """The part of a path below the place of the page; "" for one that is elsewhere."""
        _, first, *rest = [*path.split("/", 2), ""][:3]
        return f"/{rest[0]}" if _same(f"/{first}", self.keys.place) and path.count("/") > 1 else ""

    @staticmethod
    def _is_plain(path: str) -> bool:
        """True for a path of ours without escapes of anything but plain characters, empty parts or steps upwards."""
        path = unquote(path)
        if not set(path) <= PLAIN or any(part in (".", "..") for part in path.split("/")) or "//" in path:
            return False
        return path in PATHS or path.startswith(FOLDERS)

    def _is_ours(self, origin: str) -> bool:
        try:
            found = urlsplit(origin.strip())
        except ValueError:
            return False
        return found.scheme == "http" and found.netloc.lower() in self.hosts and found.path in ("", "/")

    @staticmethod
    def _is_visit(below: str, headers: HTTPHeaders) -> bool:
        """True where a link elsewhere was followed to the page, which then needs the secrets as from anywhere."""
        return (
            below in ("", "/")
            and headers.get("Sec-Fetch-Mode") == "navigate"
            and headers.get("Sec-Fetch-Dest", "document") == "document"
        )

    def _has_cookie(self, headers: HTTPHeaders) -> bool:
        """True if any cookie is ours; pages of other ports may have set more, of the same name or not well-formed."""
        pairs = [pair.partition("=") for header in headers.get_list("Cookie") for pair in header.split(";")]
        return any(
            name.strip() == self.cookie_name and _same(value.strip(), self.keys.cookie) for name, _, value in pairs
        )

    # ------------------------------------------------------------ what is said
    def headers(self) -> dict[str, str]:
        """Headers of every answer: nothing is loaded from elsewhere, shown inside of another page, or kept."""
        own = " ".join(f"ws://{host}" for host in sorted(self.hosts) if "[" not in host)
        policy = (
            "default-src 'self'; script-src 'self' 'unsafe-inline' 'unsafe-eval' blob:; worker-src 'self' blob:;"
            " style-src 'self' 'unsafe-inline'; img-src 'self' data: blob:; font-src 'self' data:;"
            f" connect-src 'self' blob: data: {own}; frame-src blob:; object-src 'none'; base-uri 'none';"
            " form-action 'none'; frame-ancestors 'none'"
        )
        return {
            "Content-Security-Policy": policy,
            "X-Content-Type-Options": "nosniff",
            "X-Frame-Options": "DENY",
            "Referrer-Policy": "no-referrer",
            "Cross-Origin-Resource-Policy": "same-origin",
            "Cross-Origin-Opener-Policy": "same-origin",
        }

    def set_cookie(self) -> str:
        """The header that gives the browser its cookie, in exchange for the token."""
        return f"{self.cookie_name}={self.keys.cookie}; Path={self.keys.place}/; HttpOnly; SameSite=Strict"


def _same(given: str, secret: str) -> bool:
    """Comparison in a time that says nothing about the secret."""
    return hmac.compare_digest(given.encode("utf-8", "surrogateescape"), secret.encode())


def _names_session(headers: HTTPHeaders) -> bool:
    """True if a web socket is asked for with the token of a session as Bokeh makes them, which it takes for granted."""
    words = [one.strip() for one in headers.get("Sec-WebSocket-Protocol", "").split(",")]
    if len(words) != 2 or words[0] != "bokeh":
        return False
    try:
        expiry = get_token_payload(words[1])["session_expiry"]
        session = get_session_id(words[1])
        return isinstance(session, str) and session != "" and expiry > time.time()
    except Exception:  # of its base64, its zlib, its JSON, or what that holds
        return False


class _Door(HTTPMessageDelegate):
    """One request: refused, its token exchanged for the cookie, or passed on."""

    def __init__(self, guard: Guard, server_conn: object, request_conn: Any) -> None:
        self.guard, self.server_conn, self.conn = guard, server_conn, request_conn
        self.onward: HTTPMessageDelegate | None = None
        self.with_body = True
        self.answer: tuple[int, str, dict[str, str], str] | None = None

    def headers_received(self, start_line: Any, headers: HTTPHeaders) -> Awaitable[None] | None:
        why = self.guard.why_not(start_line, headers)
        self.with_body = start_line.method != "HEAD"
        path, _, query = start_line.path.partition("?")
        if why:
            self.answer = 403, "Forbidden", {"Connection": "close"}, REFUSED
        elif token := self.guard.token_of(path, query):  # the address that the browser keeps is without it
            self.guard.keys.spend(token)
            page = f"{self.guard.keys.place}/"
            cookie = {"Set-Cookie": self.guard.set_cookie()}
            if headers.get("Sec-Fetch-Site") == "cross-site":  # a link elsewhere: redirected, it would lack the cookie
                self.answer = 200, "OK", {"Content-Type": "text/html; charset=utf-8", **cookie}, ONWARD.format(page)
            else:
                self.answer = 303, "See Other", {"Location": page, **cookie}, ""
        else:
            if path == self.guard.keys.place + ICON:
                start_line = start_line._replace(path=ICON)  # which Bokeh has nowhere else
            self.onward = self.guard.application.start_request(self.server_conn, self.conn)
            answer: Awaitable[None] | None = self.onward.headers_received(start_line, headers)
            return answer
        if "chunked" in headers.get("Transfer-Encoding", "") or headers.get("Content-Length", "0") != "0":
            self.answer[2]["Connection"] = "close"
        return None

    def data_received(self, chunk: bytes) -> Awaitable[None] | None:
        answer: Awaitable[None] | None = self.onward.data_received(chunk) if self.onward is not None else None
        return answer

    def finish(self) -> None:
        if self.onward is not None:
            self.onward.finish()
            return
        if self.answer is None:
            return
        status, reason, more, text = self.answer
        body = text.encode() if self.with_body else b""
        headers = HTTPHeaders(
            {
                **self.guard.headers(),
                "Content-Type": "text/plain; charset=utf-8",
                "Content-Length": str(len(body)),
                "Cache-Control": "no-store",
                **more,
            }
        )
        self.conn.write_headers(ResponseStartLine("HTTP/1.1", status, reason), headers, body)
        self.conn.finish()

    def on_connection_close(self) -> None:
        if self.onward is not None:
            self.onward.on_connection_close()
