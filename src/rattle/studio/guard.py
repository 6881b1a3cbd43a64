"""Who may ask the studio: every request is checked here before anything else sees it.

A request passes if it comes from the page that the studio itself has sent to the user who was given its address:

* `Host` is one of our own names with our port.  A foreign site whose name is made to lead to this computer (DNS
  rebinding) has its own name there.  (Starlette's own check of it leaves the port out, and knows no IPv6.)
* `Origin`, where a browser sends it, is our own page; `Sec-Fetch-Site` says the same of newer browsers.
* It knows the secrets: a token in the address, which is spent by its first use and exchanged for the place of the
  page, a path that nobody guesses, and for a cookie that scripts cannot read, that no other site makes the browser
  send, and that belongs to this path alone: what listens on other ports of this computer never gets it, though cookies
  do not know ports (RFC 6265, section 8.5).
* The path is one of the few that the page needs, letter by letter, and nothing is sent with it.

Source: OWASP, Cross-Site Request Forgery Prevention Cheat Sheet; Jackson et al., Protecting browsers from DNS rebinding
attacks, ACM Transactions on the Web 3 (2009).
"""

from __future__ import annotations

import hmac
import secrets
from collections.abc import Collection
from urllib.parse import parse_qs, urlsplit

from starlette.datastructures import Headers
from starlette.responses import HTMLResponse, PlainTextResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Receive, Scope, Send

METHODS = ("GET", "HEAD")  # the page asks for nothing else; all that changes anything goes over its web socket
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
        return any(_same(token, issued) for issued in self._tokens)

    def spend(self, token: str) -> None:
        """From now on this token is worth nothing."""
        self._tokens.discard(token)


class Guard:
    """Passes requests on to `application` that may be answered, with their path below its place; refuses all others.

    paths: all that there is below the place.  hosts: names of this computer under which the studio may be reached.
    port: ours.
    """

    def __init__(
        self, application: ASGIApp, paths: Collection[str], keys: Secrets, hosts: Collection[str], port: int
    ) -> None:
        self.application, self.paths, self.keys = application, paths, keys
        self.hosts = {f"{host}:{port}".lower() for host in hosts}
        self.cookie_name = f"rattle-studio-{port}"

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request; the server calls this."""
        headers, path = Headers(scope=scope), scope["raw_path"].decode("latin-1")
        method = scope.get("method", "GET")  # of a web socket
        below = self._below(path)
        answer: ASGIApp = self.application
        if self._is_refused(scope["type"], method, path, headers):
            answer = PlainTextResponse(REFUSED, 403, {"Connection": "close"})
        elif path == "/":
            token = "" if method != "GET" or "Sec-Purpose" in headers else self._token_in(scope["query_string"])
            answer = self._entry(token, headers)  # looking ahead must not spend the token
        elif not self._has_cookie(headers):
            answer = PlainTextResponse(REFUSED, 403, {"Connection": "close"})
        await answer({**scope, "path": below, "raw_path": below.encode()}, receive, send)

    # ------------------------------------------------------------ the checks
    def _is_refused(self, kind: str, method: str, path: str, headers: Headers) -> bool:
        """True for a request that is refused whatever it knows."""
        hosts, origins, below = headers.getlist("Host"), headers.getlist("Origin"), self._below(path)
        sends = "Transfer-Encoding" in headers or headers.get("Content-Length", "0") != "0"
        site = headers.get("Sec-Fetch-Site", "none")
        return (
            method not in METHODS
            or sends
            or (path != "/" and below not in self.paths)
            or (kind == "websocket") != (below == "/ws")
            or len(hosts) != 1
            or hosts[0].strip().lower() not in self.hosts
            or not all(map(self._is_ours, origins))
            or (kind == "websocket" and not origins)  # a browser always sends it
            or (site not in ("none", "same-origin") and not _is_visit(path, below, headers))
            or headers.get("Sec-Fetch-Dest", "document") in FRAMES
        )

    def _token_in(self, query: bytes) -> str:
        """The token in the address of the page if it is worth something; "" otherwise."""
        tokens = parse_qs(query.decode("latin-1")).get("token", [])
        return tokens[0] if len(tokens) == 1 and self.keys.knows(tokens[0]) else ""

    def _below(self, path: str) -> str:
        """The part of a path below the place of the page; "" for one that is elsewhere."""
        _, first, *rest = [*path.split("/", 2), ""][:3]
        return f"/{rest[0]}" if _same(f"/{first}", self.keys.place) and path.count("/") > 1 else ""

    def _is_ours(self, origin: str) -> bool:
        try:
            place = urlsplit(origin.strip())
        except ValueError:
            return False
        return place.scheme == "http" and place.netloc.lower() in self.hosts and place.path in ("", "/")

    def _has_cookie(self, headers: Headers) -> bool:
        """True if any cookie is ours; pages of other ports may have set more, of the same name or not well-formed."""
        pairs = [pair.partition("=") for header in headers.getlist("Cookie") for pair in header.split(";")]
        return any(
            name.strip() == self.cookie_name and _same(value.strip(), self.keys.cookie) for name, _, value in pairs
        )

    # ------------------------------------------------------------ what is said
    def _entry(self, token: str, headers: Headers) -> Response:
        """The way from the address with the token to the page, whose address is without it."""
        if not token:
            return PlainTextResponse(REFUSED, 403, {"Connection": "close"})
        self.keys.spend(token)
        page = f"{self.keys.place}/"
        cookie = f"{self.cookie_name}={self.keys.cookie}; Path={page}; HttpOnly; SameSite=Strict"
        if headers.get("Sec-Fetch-Site") == "cross-site":  # a link elsewhere: redirected, it would lack the cookie
            return HTMLResponse(ONWARD.format(page), headers={"Set-Cookie": cookie})
        return RedirectResponse(page, 303, {"Set-Cookie": cookie})

    def headers(self) -> dict[str, str]:
        """Headers of every answer: nothing is loaded from elsewhere, shown inside of another page, or kept.

        'unsafe-eval' is for programs that drive the page by `window.rattle` and wait for a condition; the page itself
        makes no scripts of texts.
        """
        own = " ".join(f"ws://{host}" for host in sorted(self.hosts) if "[" not in host)
        policy = (
            "default-src 'self'; script-src 'self' 'unsafe-eval' blob:; worker-src 'self' blob:;"
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
            "Cache-Control": "no-store",
        }


def _same(text: str, secret: str) -> bool:
    """Comparison in a time that says nothing about the secret."""
    return hmac.compare_digest(text.encode("utf-8", "surrogateescape"), secret.encode())


def _is_visit(path: str, below: str, headers: Headers) -> bool:
    """True where a link elsewhere was followed to the page, which then needs the secrets as from anywhere."""
    return (
        (path == "/" or below == "/")
        and headers.get("Sec-Fetch-Mode") == "navigate"
        and headers.get("Sec-Fetch-Dest", "document") == "document"
    )
