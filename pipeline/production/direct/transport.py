"""Transport: messages over standard input and output, a local socket, or a TCP port.

Each line is a message. A local socket is open to its owner alone, from the moment that it exists.
A port is open to this machine alone unless its host is given, and there to whoever has its token.
Both are closed once the director has connected, because a scene has one.
"""

from __future__ import annotations

import contextlib
import ipaddress
import os
import socket
import stat
import sys
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path

from pipeline.errors import StoreError, UsageError
from pipeline.production.direct.access_token import token_in
from pipeline.production.direct.admission import Admission
from pipeline.production.direct.message_stream import (
    MessageStream,
    pipe_writer,
    socket_reader,
    socket_writer,
)
from pipeline.production.run.outputs import Outputs
from pipeline.text_stream import print_text

Announce = Callable[[str], None]
Transport = Callable[[Announce], AbstractContextManager[MessageStream]]
"""Opens a message stream and announces its address."""

LOOPBACK = "127.0.0.1"

BACKLOG = 128
"""Connections that wait to be accepted."""


def transport_for(
    path: Path | None,
    number: int | None,
    host: str,
    token_file: Path | None,
    outputs: Outputs,
    quiet: bool = False,
) -> Transport:
    """Return the transport for these options, by default standard input and output.

    Args:
        path: of a local socket.
        number: of a TCP port.
        host: address of the port.
        token_file: for the port's token; None for a file among the outputs.
        outputs: of the directed scene.
        quiet: whether only errors are reported, and the address of a free port, which nothing else
            tells.

    Raises:
        UsageError: the options contradict each other, or the socket is occupied.
    """
    if path is not None and number is not None:
        raise UsageError("--socket and --port conflict; give one of them")
    if number is None and host != LOOPBACK:
        raise UsageError("--host is the address of a port; give --port as well")
    if number is None and token_file is not None:
        raise UsageError("--token-file is for the token of a port; give --port as well")
    if path is not None:
        return local_socket(path)
    if number is None:
        return standard_streams
    announce_address = _print_address if quiet and number == 0 else None
    return tcp_port(number, host, token_file or outputs.token, announce_address)


def _print_address(text: str) -> None:
    print_text(sys.stderr, text)


@contextmanager
def standard_streams(announce: Announce) -> Iterator[MessageStream]:
    """Open standard input and output; other prints go to standard error."""
    del announce
    sys.stdout.flush()
    out = os.dup(1)
    os.dup2(2, 1)
    try:
        with (
            open(0, "rb", closefd=False) as reader,
            pipe_writer(out) as writer,
        ):
            yield MessageStream(reader, writer)
    finally:
        sys.stdout.flush()
        os.dup2(out, 1)
        os.close(out)


def local_socket(path: Path) -> Transport:
    """Return the transport over a local socket at `path`, for its owner alone.

    Raises:
        UsageError: the path is occupied.
    """
    _refuse_occupied(path)

    @contextmanager
    def transport(announce: Announce) -> Iterator[MessageStream]:
        with contextlib.closing(socket.socket(socket.AF_UNIX)) as listener:
            before = os.umask(0o177)
            try:
                listener.bind(str(path))
            except OSError as error:
                reason = error.strerror or str(error)
                raise StoreError(f"{path}: no socket can be made there ({reason})") from error
            finally:
                os.umask(before)
            try:
                listener.listen(BACKLOG)
                announce(f"waiting at {path}")
                director = Admission(listener, None, announce).director()
            finally:
                path.unlink(missing_ok=True)
        with _stream(*director) as stream:
            yield stream

    return transport


def tcp_port(
    number: int, host: str, token_file: Path, announce_address: Announce | None = None
) -> Transport:
    """Return the transport over a TCP port; 0 takes a free one and announces it.

    The first line of the program that connects has to hold the token, which is in `token_file`
    while the port waits.

    Args:
        number: of the port.
        host: its address.
        token_file: for the token.
        announce_address: announces the address, None to announce it as all else.
    """

    @contextmanager
    def transport(announce: Announce) -> Iterator[MessageStream]:
        family, address = _address(host, number)
        with contextlib.closing(socket.socket(family)) as listener:
            try:
                listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
                listener.bind(address)
                # Before the token is there: who finds it may connect at once.
                listener.listen(BACKLOG)
            except OSError as error:
                reason = error.strerror or str(error)
                raise StoreError(f"{host}:{number}: cannot be listened at ({reason})") from error
            with token_in(token_file) as token:
                _announce_token(listener, token, token_file, announce)
                (announce_address or announce)(f"waiting at {_place(listener)}")
                director = Admission(listener, token, announce).director()
        # A director whose machine has failed says no goodbye.
        director[0].setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
        with _stream(*director) as stream:
            yield stream

    return transport


def _announce_token(
    listener: socket.socket, token: str, token_file: Path, announce: Announce
) -> None:
    place = _place(listener)
    if not ipaddress.ip_address(listener.getsockname()[0]).is_loopback:
        announce(f"note: {place} is open to other machines; the token crosses the network as it is")
    announce(f"token {token} (in {token_file})")


def _place(listener: socket.socket) -> str:
    return "{}:{}".format(*listener.getsockname()[:2])


def _address(host: str, number: int) -> tuple[socket.AddressFamily, tuple[str, int]]:
    try:
        found = socket.getaddrinfo(host, number, type=socket.SOCK_STREAM)[0]
    except (OSError, UnicodeError) as error:
        raise UsageError(f"--host {host!r} is no address of this machine") from error
    return found[0], (str(found[4][0]), number)


@contextmanager
def _stream(connection: socket.socket, received: bytes) -> Iterator[MessageStream]:
    """Open the messages of a connection of which something was received already."""
    with (
        connection,
        socket_reader(connection, received) as reader,
        socket_writer(connection) as writer,
    ):
        yield MessageStream(reader, writer)


def _refuse_occupied(path: Path) -> None:
    """Remove the socket of a run that was killed; refuse anything else at `path`."""
    if not hasattr(socket, "AF_UNIX"):
        raise UsageError("there are no local sockets on this system; give --port")
    try:
        mode = path.lstat().st_mode
    except FileNotFoundError:
        return
    except OSError as error:
        raise UsageError(f"{path}: no socket can be made there ({error.strerror})") from error
    if not stat.S_ISSOCK(mode):
        raise UsageError(f"{path}: there is something else already; choose another place")
    with socket.socket(socket.AF_UNIX) as probe:
        try:
            probe.connect(str(path))
        except OSError:
            path.unlink(missing_ok=True)
            return
    raise UsageError(f"{path}: another run waits there already; choose another place")
