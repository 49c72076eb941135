# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""HTTP server of one page on this machine, with server-sent events."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
import errno
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
import json
import queue
import threading
from typing import Any

from fpnet_core.errors import FpnetError

HOST = '127.0.0.1'
"""Given: loopback address; the positions of a robot are not served to other machines."""

# Numerical: a client that is behind by more events is dropped; after so many seconds without an
# event, a client gets a keep-alive message.
_BEHIND, _QUIET_S = 500, 15.0

_POLICY = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "img-src data: blob:; connect-src 'self'; frame-ancestors 'none'"
)

Event = Mapping[str, Any]


class LiveServer:
    """
    A server for one page and its events only.

    Parameters
    ----------
    page : HTML, which reads server-sent events from ``events``
    whole : returns the first event of a newly opened page; called between two events
    port : 0 takes a free one

    Raises
    ------
    FpnetError
        If the port is taken or not permitted.
    """

    def __init__(self, page: str, whole: Callable[[], Event], port: int) -> None:
        self._page, self._whole = page.encode('utf-8'), whole
        self._lock = threading.Lock()
        self._clients: list[queue.Queue[bytes | None]] = []
        try:
            self._server = ThreadingHTTPServer((HOST, port), _handler(self))
        except OSError as error:
            raise FpnetError(_unavailable(port, error)) from None
        self._server.daemon_threads = True
        threading.Thread(target=self._server.serve_forever, daemon=True).start()

    @property
    def url(self) -> str:
        """URL of the page."""
        return f'http://{HOST}:{self._server.server_port}/'

    def replace(self, page: str, change: Callable[[], None]) -> None:
        """Serve another page from now on; open pages reload."""

        def anew() -> None:
            self._page = page.encode('utf-8')
            change()

        self.tell({'kind': 'reload'}, anew)

    def tell(self, event: Event, change: Callable[[], None]) -> None:
        """
        Send an event to all open pages.

        ``change`` adds it to the state that ``whole`` returns, under the same lock, so that a page
        opened meanwhile receives it exactly once.
        """
        message = _message(event)
        with self._lock:
            change()
            for client in list(self._clients):
                try:
                    client.put_nowait(message)
                except queue.Full:
                    self._clients.remove(client)

    def close(self) -> None:
        """Close all event streams and the server."""
        with self._lock:
            for client in self._clients:
                with suppress(queue.Full):  # a client with a full queue ends with the process
                    client.put_nowait(None)
            self._clients.clear()
        self._server.shutdown()
        self._server.server_close()

    def _join(self) -> queue.Queue[bytes | None]:
        client: queue.Queue[bytes | None] = queue.Queue(_BEHIND)
        with self._lock:
            client.put(_message(self._whole()))
            self._clients.append(client)
        return client

    def _leave(self, client: queue.Queue[bytes | None]) -> None:
        with self._lock:
            if client in self._clients:
                self._clients.remove(client)

    def _is_ours(self, host: str | None) -> bool:
        """Return whether a request names this machine, against DNS rebinding by other sites."""
        port = self._server.server_port
        return host in (f'{HOST}:{port}', f'localhost:{port}')


def _handler(live: LiveServer) -> type[BaseHTTPRequestHandler]:
    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            if not live._is_ours(self.headers.get('Host')):
                self.send_error(HTTPStatus.FORBIDDEN)
            elif self.path == '/':
                page = live._page
                self._begin('text/html; charset=utf-8', len(page))
                self.wfile.write(page)
            elif self.path == '/events':
                self._begin('text/event-stream')
                self._follow()
            else:
                self.send_error(HTTPStatus.NOT_FOUND)

        def _begin(self, kind: str, length: int | None = None) -> None:
            self.send_response(HTTPStatus.OK)
            headers = {
                'Content-Type': kind,
                'Cache-Control': 'no-store',
                'Content-Security-Policy': _POLICY,
                'X-Content-Type-Options': 'nosniff',
            }
            if length is not None:
                headers['Content-Length'] = str(length)
            for name, value in headers.items():
                self.send_header(name, value)
            self.end_headers()

        def _follow(self) -> None:
            client = live._join()
            try:
                while (message := _next(client)) is not None:
                    self.wfile.write(message)
                    self.wfile.flush()
            except OSError:  # the page was closed
                pass
            finally:
                live._leave(client)

        def log_message(self, *_: Any) -> None:
            """Log nothing: the output belongs to the command."""

    return Handler


def _next(client: queue.Queue[bytes | None]) -> bytes | None:
    try:
        return client.get(timeout=_QUIET_S)
    except queue.Empty:
        return b': still here\n\n'


def _message(event: Event) -> bytes:
    return f'data: {json.dumps(event, separators=(",", ":"))}\n\n'.encode()


def _unavailable(port: int, error: OSError) -> str:
    if error.errno == errno.EADDRINUSE:
        return (
            f'port {port} of {HOST} is taken; choose another one with --port, or 0 for a free one'
        )
    return f'port {port} of {HOST}: {error.strerror}; choose another one with --port'
