"""Access: what every request must be before anything is served.

Every page of a browser can send requests to a port of this machine, under another name for it
(DNS rebinding) too. So the host must be this machine's, a stated origin this page's, and the token
of the address right; and a message is read only up to a bound.

Source: Jackson et al. 2007.
"""

from __future__ import annotations

import base64
import contextlib
import hashlib
import hmac
import secrets
from collections.abc import Awaitable, Callable, MutableMapping
from dataclasses import dataclass
from typing import Any
from urllib.parse import parse_qs

TOKEN_BYTES = 32
"""Random bytes of a token."""

MAX_MESSAGE_BYTES = 4 * 2**20
"""Longest message of the page: half of the longest file, which JSON can make longer [bytes]."""

TOO_LONG = 413
"""Status of a message beyond the bound."""

TOKEN_HEADER = b"x-studio-token"

NO_TOKEN = "no token; open the address that `pronk studio` printed"

RELOAD = (
    b"const token = sessionStorage.studioToken;"
    b'if (token) location.replace("/?again&token=" + encodeURIComponent(token));'
)
"""Script of the refusal at the address without a token: a tab that had the page loads it again.

The page takes the token out of its address, and keeps it where this tab and this port alone read.
"""


def _headers(scripts: bytes) -> tuple[tuple[bytes, bytes], ...]:
    """Return headers of an answer: nothing is kept or comes from elsewhere, and nobody frames it.

    Args:
        scripts: that may run.
    """
    return (
        (b"cache-control", b"no-store"),
        (b"referrer-policy", b"no-referrer"),
        (b"x-content-type-options", b"nosniff"),
        (b"x-frame-options", b"DENY"),
        (b"cross-origin-resource-policy", b"same-origin"),
        (
            b"content-security-policy",
            b"default-src 'none'; script-src " + scripts + b"; style-src 'self' 'unsafe-inline'; "
            b"img-src 'self' blob: data:; connect-src 'self' blob:; media-src blob:; "
            b"base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
        ),
    )


HEADERS = _headers(b"'self'")
"""Of every answer of the application."""

RELOAD_HEADERS = _headers(b"'sha256-%s'" % base64.b64encode(hashlib.sha256(RELOAD).digest()))
"""Of the refusal with the script that loads the page again."""

Message = MutableMapping[str, Any]
Scope = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]
Application = Callable[[Scope, Receive, Send], Awaitable[None]]


def new_token() -> str:
    """Return a token that nobody can guess."""
    return secrets.token_urlsafe(TOKEN_BYTES)


class TooLong(Exception):
    """A message goes on beyond the bound."""


@dataclass(frozen=True, slots=True)
class Guard:
    """Refuses what is not this page's, and passes on the rest.

    Attributes:
        application: behind it.
        token: of the address.
        port: that it is served on.
    """

    application: Application
    token: str
    port: int

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one request."""
        if scope["type"] == "lifespan":
            await self.application(scope, receive, send)
            return
        if scope["type"] != "http":
            raise ValueError("the studio speaks HTTP alone")
        status, reason = self._fault(scope)
        if status:
            if status != TOO_LONG:
                # A connection that is closed before all is read loses the answer.
                await _drain(receive)
            is_reload = reason == NO_TOKEN and scope["path"] == "/" and not scope["query_string"]
            await _refuse(send, status, reason, is_reload)
            return
        await self._pass_on(scope, receive, send)

    def _fault(self, scope: Scope) -> tuple[int, str]:
        """Return the status and reason of a refusal, 0 for none."""
        headers = dict[bytes, list[bytes]]()
        for name, value in scope["headers"]:
            headers.setdefault(name.lower(), []).append(value)
        names = {f"{host}:{self.port}".encode() for host in ("127.0.0.1", "localhost")}
        host = headers.get(b"host", [])
        if len(host) != 1 or host[0] not in names:
            return 403, "another host"
        origins = headers.get(b"origin", [])
        if any(origin not in {b"http://" + name for name in names} for origin in origins):
            return 403, "another origin"
        if not self._is_token(scope, headers.get(TOKEN_HEADER, [])):
            return 403, NO_TOKEN
        length = headers.get(b"content-length", [b"0"])[0]
        if not length.isdigit() or int(length) > MAX_MESSAGE_BYTES:
            return TOO_LONG, f"longer than {MAX_MESSAGE_BYTES} bytes"
        return 0, ""

    def _is_token(self, scope: Scope, given: list[bytes]) -> bool:
        try:
            query = parse_qs(scope.get("query_string", b""), max_num_fields=16)
        except ValueError:
            # Too many fields, or escapes that are not ASCII.
            query = {}
        tokens = [*given, *query.get(b"token", [])]
        return any(hmac.compare_digest(one, self.token.encode()) for one in tokens)

    async def _pass_on(self, scope: Scope, receive: Receive, send: Send) -> None:
        received = 0

        async def bounded() -> Message:
            nonlocal received
            message = await receive()
            # Also where the length is not said first, or wrongly.
            received += len(message.get("body", b""))
            if received > MAX_MESSAGE_BYTES:
                raise TooLong
            return message

        async def guarded(message: Message) -> None:
            if received > MAX_MESSAGE_BYTES:
                # What the application says of its interruption.
                return
            if message["type"] == "http.response.start":
                message["headers"] = [*message.get("headers", []), *HEADERS]
            await send(message)

        with contextlib.suppress(TooLong):
            await self.application(scope, bounded, guarded)
        if received > MAX_MESSAGE_BYTES:
            await _refuse(send, TOO_LONG, f"longer than {MAX_MESSAGE_BYTES} bytes")


async def _drain(receive: Receive) -> None:
    """Read a message and forget it, up to the bound."""
    received = 0
    while received <= MAX_MESSAGE_BYTES:
        message = await receive()
        received += len(message.get("body", b""))
        if not message.get("more_body"):
            return


async def _refuse(send: Send, status: int, reason: str, is_reload: bool = False) -> None:
    body = f"refused: {reason}\n".encode()
    kind = b"html" if is_reload else b"plain"
    headers = [
        (b"content-type", b"text/%s; charset=utf-8" % kind),
        (b"connection", b"close"),
        *(RELOAD_HEADERS if is_reload else HEADERS),
    ]
    if is_reload:
        body += b"<script>%s</script>\n" % RELOAD
    await send({"type": "http.response.start", "status": status, "headers": headers})
    await send({"type": "http.response.body", "body": body})
