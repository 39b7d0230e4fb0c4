"""The explorer served on this machine: the page, and the answers to its questions.

Nobody else can use it. It listens only on 127.0.0.1 and answers only requests that have its token,
name its own address as their host, and are short.
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

from escapement.base.errors import EscapementError

MOST_BYTES = 1_000_000
"""A longer question is refused; a table of measured angles is shorter."""
_WAITING = 200  # connections that the system keeps waiting
_PATIENCE = 20.0  # seconds that a connection may take to send its request
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
        Returns the page for the server's token.
    asked : dict of callable
        Functions that answer a question, by the path to which it is sent.
    """

    daemon_threads = True
    request_queue_size = _WAITING

    def __init__(self, page: Callable[[str], str], asked: dict[str, Ask]) -> None:
        super().__init__(("127.0.0.1", 0), _Handler)
        self.token = secrets.token_urlsafe(24)
        self.page = page(self.token).encode()
        self.asked = asked
        # questions to the same path are answered one at a time
        self.turns = {path: threading.Lock() for path in asked}

    @property
    def url(self) -> str:
        """Address of the page."""
        return f"http://127.0.0.1:{self.server_port}/?token={self.token}"

    def knows(self, token: str) -> bool:
        """Whether this is the server's token."""
        return hmac.compare_digest(token.encode(), self.token.encode())

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Ignore a browser that closed its connection early."""


class _Handler(BaseHTTPRequestHandler):
    server: Server
    timeout = _PATIENCE
    server_version, sys_version = "escapement", ""

    def do_GET(self) -> None:
        """Send the page."""
        address = urlsplit(self.path)
        token = parse_qs(address.query).get("token", [""])[0]
        if self._refused(token):
            return
        if address.path != "/":
            self._tell(HTTPStatus.NOT_FOUND, "the page is at /; open that address")
            return
        self._send(HTTPStatus.OK, "text/html; charset=utf-8", self.server.page)

    def do_POST(self) -> None:
        """Answer a question."""
        if self._refused(self.headers.get("X-Token", "")):
            return
        ask = self.server.asked.get(self.path)
        if ask is None:
            known = " or ".join(self.server.asked)
            self._tell(HTTPStatus.NOT_FOUND, f"a question must be sent to {known}")
            return
        length = self.headers.get("Content-Length", "")
        if not length.isdecimal():
            rule = "a question must have a Content-Length header, got none; add it"
            self._tell(HTTPStatus.LENGTH_REQUIRED, rule)
        elif int(length) > MOST_BYTES:
            # a browser reads an answer only after it has sent everything
            self.rfile.read(min(int(length), 4 * MOST_BYTES))
            rule = f"a question must have at most {MOST_BYTES} bytes, got {int(length)}; shorten it"
            self._tell(HTTPStatus.REQUEST_ENTITY_TOO_LARGE, rule)
        else:
            self._answer(ask, self.rfile.read(int(length)))

    def _answer(self, ask: Ask, body: bytes) -> None:
        try:
            question = json.loads(body)
            if not isinstance(question, dict):
                raise ValueError
        except (ValueError, RecursionError):
            self._tell(HTTPStatus.BAD_REQUEST, "a question must be a JSON object; correct it")
            return
        try:
            with self.server.turns[self.path]:
                text = json.dumps(ask(question), allow_nan=False)
        except (EscapementError, ArithmeticError, MemoryError) as error:
            line = " ".join(str(error).split()) or type(error).__name__
            self._tell(HTTPStatus.UNPROCESSABLE_ENTITY, line)
            return
        except Exception as error:
            # the page waits for an answer, whatever went wrong
            line = f"the package failed ({type(error).__name__}: {error}); please report it"
            self._tell(HTTPStatus.INTERNAL_SERVER_ERROR, " ".join(line.split()))
            return
        self._send(HTTPStatus.OK, "application/json", text.encode())

    def _refused(self, token: str) -> bool:
        """Refuse a request from another site or without the token; True if it was refused."""
        port = self.server.server_port
        hosts = {f"127.0.0.1:{port}", f"localhost:{port}"}
        if self.headers.get("Host", "") not in hosts:
            # another site may let its own name point to this machine
            rule = f"the host must be 127.0.0.1:{port}; open the address that the command printed"
            self._tell(HTTPStatus.FORBIDDEN, rule)
        elif self.headers.get("Origin", "null") not in {"null", *(f"http://{x}" for x in hosts)}:
            rule = "questions must come from this server's page; open the printed address"
            self._tell(HTTPStatus.FORBIDDEN, rule)
        elif not self.server.knows(token):
            rule = "the token must be this server's; open the address that the command printed"
            self._tell(HTTPStatus.FORBIDDEN, rule)
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
        """Print nothing: requests must not disturb the terminal."""


@contextlib.contextmanager
def serving(server: Server) -> Iterator[None]:
    """Run the server in a thread until the block ends."""
    thread = threading.Thread(target=server.serve_forever, daemon=True)
    thread.start()
    try:
        yield
    finally:
        server.shutdown()
        server.server_close()
