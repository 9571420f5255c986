"""A relay between a service and its database server, so that the network can fail."""

import contextlib
import select
import socket
import threading
import time


class Relay:
    """Passes a port of loopback on to a server; can hang up, or fall silent."""

    def __init__(self, host: str, port: int) -> None:
        self._target = (host, port)
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.port = self._listener.getsockname()[1]
        self._pairs: list[tuple[socket.socket, socket.socket]] = []
        self.refuses = self.is_silent = False
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self) -> None:
        while True:
            here, _ = self._listener.accept()
            if self.refuses:
                here.close()
                continue
            there = socket.create_connection(self._target)
            self._pairs.append((here, there))
            threading.Thread(target=self._pass_on, args=(here, there), daemon=True).start()

    def _pass_on(self, here: socket.socket, there: socket.socket) -> None:
        other = {here: there, there: here}
        with contextlib.suppress(OSError, ValueError), here, there:
            while True:
                for end in select.select([here, there], [], [], 1.0)[0]:
                    while self.is_silent:
                        time.sleep(0.05)
                    data = end.recv(65536)
                    if not data:
                        return
                    other[end].sendall(data)

    def hang_up(self) -> None:
        for pair in self._pairs:
            for end in pair:
                with contextlib.suppress(OSError):
                    end.shutdown(socket.SHUT_RDWR)
        self._pairs.clear()
