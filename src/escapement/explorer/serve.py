"""The explorer served on this machine: the page, and what it asks of the package.

Nobody else is to reach it: it listens on 127.0.0.1 alone, and answers those alone who know its
token, name its own address as their host, and send little.
"""

import contextlib
import hmac
import json
import secrets
import threading
from collections.abc import Callable, Iterator
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any
from urllib.parse import parse_qs, urlsplit

from escapement.errors import EscapementError

MOST_BYTES = 1_000_000
"""A longer question is refused: a table of measured angles is shorter."""
_WAITING = 200  # connections that the system keeps until they are taken up
_PATIENCE = 20.0  # seconds that a connection may take to send what it wants
_HEADERS = {
    "Cache-Control": "no-store",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "Connection": "close",
}
Ask = Callable[[Any], dict[str, Any]]


class Server(ThreadingHTTPServer):
    """Serves a page on a free port of 127.0.0.1.

    Parameters
    ----------
    page : callable
        Makes the page of the server's token.
    asked : dict of callable
        What answers a question, by the path that it is sent to.
    """

    daemon_threads = True
    request_queue_size = _WAITING

    def __init__(self, page: Callable[[str], str], asked: dict[str, Ask]) -> None:
        super().__init__(("127.0.0.1", 0), _Handler)
        self.token = secrets.token_urlsafe(24)
        self.page = page(self.token).encode()
        self.asked = asked
        # of each kind one question at a time is answered, the others wait for it
        self.turns = {path: threading.Lock() for path in asked}

    @property
    def url(self) -> str:
        """Where a browser finds the page."""
        return f"http://127.0.0.1:{self.server_port}/?token={self.token}"

    def knows(self, token: str) -> bool:
        """Whether this is the server's token."""
        return hmac.compare_digest(token.encode(), self.token.encode())

    def handle_error(self, request: Any, client_address: Any) -> None:
        """A reader that left in the middle is no error of the server."""


class _Handler(BaseHTTPRequestHandler):
    server: Server
    timeout = _PATIENCE
    server_version, sys_version = "escapement", ""

    def do_GET(self) -> None:
        """Send the page."""
        place = urlsplit(self.path)
        token = parse_qs(place.query).get("token", [""])[0]
        if self._refused(token):
            return
        if place.path != "/":
            self._tell(HTTPStatus.NOT_FOUND, "there is nothing here but the page at /")
            return
        self._send(HTTPStatus.OK, "text/html; charset=utf-8", self.server.page)

    def do_POST(self) -> None:
        """Answer a question."""
        if self._refused(self.headers.get("X-Token", "")):
            return
        ask = self.server.asked.get(self.path)
        if ask is None:
            self._tell(HTTPStatus.NOT_FOUND, "there is nothing here to be asked")
            return
        length = self.headers.get("Content-Length", "")
        if not length.isdecimal():
            self._tell(HTTPStatus.LENGTH_REQUIRED, "a question must tell its length")
        elif int(length) > MOST_BYTES:
            # a browser hears an answer only when it has sent all
            self.rfile.read(min(int(length), 4 * MOST_BYTES))
            rule = f"a question must have at most {MOST_BYTES} bytes, got {int(length)}"
            self._tell(HTTPStatus.REQUEST_ENTITY_TOO_LARGE, rule)
        else:
            self._answer(ask, self.rfile.read(int(length)))

    def _answer(self, ask: Ask, body: bytes) -> None:
        try:
            question = json.loads(body)
            if not isinstance(question, dict):
                raise ValueError
        except (ValueError, RecursionError):
            self._tell(HTTPStatus.BAD_REQUEST, "a question must be an object of JSON")
            return
        try:
            with self.server.turns[self.path]:
                text = json.dumps(ask(question), allow_nan=False)
        except (EscapementError, ArithmeticError, MemoryError) as error:
            line = " ".join(str(error).split()) or type(error).__name__
            self._tell(HTTPStatus.UNPROCESSABLE_ENTITY, line)
            return
        except Exception as error:
            # whatever went wrong, the page that waits is to know
            line = f"the package failed ({type(error).__name__}: {error}); please report it"
            self._tell(HTTPStatus.INTERNAL_SERVER_ERROR, " ".join(line.split()))
            return
        self._send(HTTPStatus.OK, "application/json", text.encode())

    def _refused(self, token: str) -> bool:
        """Whether a request comes from elsewhere, or from somebody without the token."""
        port = self.server.server_port
        hosts = {f"127.0.0.1:{port}", f"localhost:{port}"}
        if self.headers.get("Host", "") not in hosts:
            # a page of another site may let its own name point to this machine
            self._tell(HTTPStatus.FORBIDDEN, "the host must be this server's own address")
        elif self.headers.get("Origin", "null") not in {"null", *(f"http://{x}" for x in hosts)}:
            self._tell(HTTPStatus.FORBIDDEN, "questions must come from the page of this server")
        elif not self.server.knows(token):
            self._tell(HTTPStatus.FORBIDDEN, "the token must be that of this server")
        else:
            return False
        return True

    def _tell(self, status: HTTPStatus, error: str) -> None:
        self._send(status, "application/json", json.dumps({"error": error}).encode())

    def _send(self, status: HTTPStatus, kind: str, body: bytes) -> None:
        self.close_connection = True
        self.send_response(status)
        for name, value in _HEADERS.items():
            self.send_header(name, value)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, format: str, *args: Any) -> None:
        """Say nothing: the terminal belongs to whoever started the command."""


@contextlib.contextmanager
def serving(server: Server) -> Iterator[None]:
    """The server at work in a thread, until the block ends."""
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    try:
        yield
    finally:
        server.shutdown()
        server.server_close()
