"""HAL of the virtual board under CPython, without MicroPython: pipes, or sockets on Windows."""

import os
import select
import socket
import time

import hal_pipe


def make_hal(words: list, reset):
    """Return the HAL with sockets if the first word names their port, otherwise that with pipes."""
    return (SocketHal if words[0].startswith("tcp:") else Hal)(words, reset)


class Hal(hal_pipe.Hal):
    """HAL that uses pipes by their descriptors."""

    collects = False

    def open(self) -> None:
        """Store the numbers of the descriptors."""
        self.plant_in: int = int(self.plant_in)
        self.plant_out: int = int(self.plant_out)

    def host_us(self) -> int:
        """Return the host's clock [us]; `monotonic` has steps of 16 ms on Windows."""
        return time.perf_counter_ns() // 1000

    def is_readable(self, us: int, sending: bool) -> bool:
        """Wait up to `us` until bytes arrive or some can be sent; return whether bytes arrived."""
        return bool(select.select([0], [1] if sending else [], [], us * 1e-6)[0])

    def read_line(self) -> bytes:
        """Return the bytes that have arrived."""
        return os.read(0, 1024)

    def send(self, data: bytes) -> int:
        """Send as many bytes as the line accepts without waiting; return their number."""
        if not select.select([], [1], [], 0)[1]:
            return 0
        return os.write(1, data[: hal_pipe.PIECE])

    def read_plant(self, size: int) -> bytes:
        """Return the plant's complete response."""
        data = b""
        while len(data) < size:
            chunk = os.read(self.plant_in, size - len(data))
            if not chunk:
                break
            data += chunk
        return data

    def write_plant(self, data: bytes) -> None:
        """Send data to the plant."""
        os.write(self.plant_out, data)

    def write_file(self, path: str, data: bytes) -> None:
        """Write a file and flush it to disk."""
        with open(path, "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())


class SocketHal(Hal):
    """HAL that uses two connections, for the line and the plant, each with the host's token."""

    def open(self) -> None:
        """Open both connections to the host."""
        port, token = int(str(self.plant_in).split(":")[1]), str(self.plant_out)
        self.line, self.plant = (self.connect(port, token + letter) for letter in "LP")
        self.line.setblocking(False)

    def connect(self, port: int, greeting: str):
        """Return a connection to the host."""
        connection = socket.create_connection(("127.0.0.1", port), 15.0)
        connection.settimeout(None)
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        connection.sendall(greeting.encode())
        return connection

    def is_readable(self, us: int, sending: bool) -> bool:
        """Wait up to `us` until bytes arrive or some can be sent; return whether bytes arrived."""
        line = [self.line]
        return bool(select.select(line, line if sending else [], [], us * 1e-6)[0])

    def read_line(self):
        """Return the bytes that have arrived, or None; exit if the host has disconnected."""
        try:
            return self.line.recv(1024)
        except BlockingIOError:
            return None
        except ConnectionError:
            return b""

    def send(self, data: bytes) -> int:
        """Send as many bytes as the line accepts without waiting; return their number."""
        try:
            return self.line.send(data[: hal_pipe.PIECE])
        except (BlockingIOError, ConnectionError):
            return 0

    def read_plant(self, size: int) -> bytes:
        """Return the plant's complete response."""
        data = b""
        while len(data) < size:
            try:
                chunk = self.plant.recv(size - len(data))
            except ConnectionError:
                chunk = b""
            if not chunk:
                break
            data += chunk
        return data

    def write_plant(self, data: bytes) -> None:
        """Send data to the plant; exit if the plant has disconnected."""
        try:
            self.plant.sendall(data)
        except ConnectionError:
            raise EOFError from None
