"""What the studio refuses: other hosts and origins, no token, long messages, foreign files."""

from __future__ import annotations

import contextlib
import socket
from pathlib import Path

import pytest

from pipeline.errors import UsageError
from pipeline.studio.project import LIBRARY, Project
from tests.studio.conftest import Served

PATHS = ("/", "/assets/studio.js", "/api/library", "/nowhere")


@pytest.mark.parametrize("path", PATHS)
def test_nothing_but_a_refusal_is_served_without_the_token(served: Served, path: str) -> None:
    for token in ({}, {"X-Studio-Token": "t0kem"}, {"X-Studio-Token": ""}):
        status, body = served.request("GET", path, headers=token, with_token=False)
        assert status == 403
        assert body.startswith(b"refused: no token")
    assert served.request("GET", f"{path}?token=wrong", with_token=False)[0] == 403


def test_a_tab_that_had_the_page_may_load_it_again(served: Served) -> None:
    body = served.request("GET", "/", with_token=False)[1]
    assert b"<script>" in body
    assert b"t0ken" not in body
    for path in ("/?again&token=old", "/?again", "/assets/studio.js", "//"):
        assert b"<script>" not in served.request("GET", path, with_token=False)[1]
    # Another name of this machine gets no script either.
    assert b"<script>" not in served.request("GET", "/", None, {"Host": "evil.example"}, False)[1]


def test_the_address_opens_the_page_and_its_files(served: Served) -> None:
    status, body = served.request("GET", "/?token=t0ken", with_token=False)
    assert status == 200
    assert b"/assets/studio.js?token=t0ken" in body
    for name in ("studio.js", "studio.css", "licences.txt"):
        status, body = served.request("GET", f"/assets/{name}?token=t0ken", with_token=False)
        assert (status, len(body) > 1000) == (200, True)


@pytest.mark.parametrize(
    "host", ["evil.example", "evil.example:{port}", "127.0.0.1", "[::1]:{port}"]
)
def test_another_name_of_this_machine_is_refused(served: Served, host: str) -> None:
    given = host.format(port=served.port)
    status, body = served.request("POST", "/api/library", b"{}", {"Host": given})
    assert (status, body) == (403, b"refused: another host\n")


@pytest.mark.parametrize("origin", ["https://evil.example", "null", "http://127.0.0.1:1", ""])
def test_another_page_is_refused(served: Served, origin: str) -> None:
    status, body = served.request("POST", "/api/library", b"{}", {"Origin": origin})
    assert (status, body) == (403, b"refused: another origin\n")
    own = f"http://localhost:{served.port}"
    assert served.request("POST", "/api/library", b"{}", {"Origin": own})[0] == 200


def test_a_message_of_100_mb_is_refused_before_it_is_sent(served: Served) -> None:
    with socket.create_connection(("127.0.0.1", served.port), timeout=10) as client:
        head = f"POST /api/open?token=t0ken HTTP/1.1\r\nHost: 127.0.0.1:{served.port}\r\n"
        client.sendall(f"{head}Content-Length: 100000000\r\n\r\n".encode())
        assert client.recv(64).startswith(b"HTTP/1.1 413")


def test_a_message_whose_length_is_not_said_is_refused_at_the_bound(served: Served) -> None:
    with socket.create_connection(("127.0.0.1", served.port), timeout=10) as client:
        head = f"POST /api/open?token=t0ken HTTP/1.1\r\nHost: 127.0.0.1:{served.port}\r\n"
        client.sendall(f"{head}Transfer-Encoding: chunked\r\n\r\n".encode())
        piece = b" " * 65536
        sent = 0
        with contextlib.suppress(OSError):
            while sent < 100_000_000:
                client.sendall(b"%x\r\n%s\r\n" % (len(piece), piece))
                sent += len(piece)
        # What lies in the buffers of the system was sent, and not read.
        assert sent < 100_000_000
    assert served.ask("library")[0] == 200


@pytest.mark.parametrize(
    "name",
    [
        *("../secret.yaml", "figures/../../secret.yaml", "/etc/passwd", "..\\secret.yaml"),
        *(".hidden.yaml", "", ".", "a\0.yaml", "C:/x.yaml", f"{LIBRARY}../pyproject.toml"),
        *("notes.txt", f"{LIBRARY}/etc/passwd.yaml", "//secret.yaml", "link.yaml", "out/x.yaml"),
    ],
)
def test_files_outside_of_the_project_are_neither_read_nor_written(
    served: Served, name: str
) -> None:
    (served.folder / "link.yaml").symlink_to(served.folder.parent / "secret.yaml")
    (served.folder / "out").symlink_to(served.folder.parent)
    assert served.ask("open", name=name)[0] == 422
    status, answer = served.ask("save", name=name, text="pronk: 1\n")
    assert status == 422, answer
    assert (served.folder.parent / "secret.yaml").read_text() == "pronk: 1\ncast: []\n"
    assert not (served.folder.parent / "x.yaml").exists()


@pytest.mark.parametrize(
    "path", ["/assets/..%2fapp.py", "/assets/index.html", "/assets/%2e%2e/app.py"]
)
def test_other_files_of_the_program_are_not_served(served: Served, path: str) -> None:
    assert served.request("GET", path)[0] == 404


@pytest.mark.parametrize("body", [b"", b"{", b"[]", b"\xff"])
def test_a_message_that_is_no_object_is_refused(served: Served, body: bytes) -> None:
    assert served.request("POST", "/api/open", body)[0] == 400


def test_a_document_of_the_library_is_saved_as_a_copy_once(tmp_path: Path) -> None:
    project = Project.at(tmp_path)
    name = f"{LIBRARY}figures/beetle.yaml"
    text = project.read(name).text
    assert project.write(name, text) == "figures/beetle.yaml"
    assert project.read("figures/beetle.yaml").text == text
    with pytest.raises(UsageError, match="already"):
        project.write(name, text + "# changed\n")
    listed = project.listed()
    assert {"name": "figures/beetle.yaml", "kind": "figure"} in listed
    assert {"name": f"{LIBRARY}first_steps.yaml", "kind": "scene"} in listed


@pytest.mark.parametrize("query", ["&".join("a=1" for _ in range(20)), "a=%C3%A9"])
def test_odd_queries_are_refused_like_those_without_a_token(served: Served, query: str) -> None:
    status, body = served.request("GET", f"/?{query}", with_token=False)
    assert (status, body.startswith(b"refused: no token")) == (403, True)


def test_odd_messages_get_one_clear_error(served: Served) -> None:
    deep = b"[" * 100_000
    assert served.request("POST", "/api/open", deep)[0] == 400
    drawing = b'{"nodes": {"a": {"at": [1' + b"0" * 400 + b', 0]}}, "chains": [], "settings": {}}'
    body = b'{"text": "", "drawing": ' + drawing + b"}"
    assert served.request("POST", "/api/analyse", body)[0] == 422
