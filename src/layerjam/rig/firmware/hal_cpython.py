"""The same board of pipes under CPython, where there is no MicroPython; of sockets on Windows."""

import os
import select
import socket
import time

import hal_pipe


def hal(words: list, reset):
    """The board of sockets where the first word names their port, else that of pipes."""
    return (SocketHal if words[0].startswith("tcp:") else Hal)(words, reset)


class Hal(hal_pipe.Hal):
    """The pipes by their descriptors."""

    collects = False

    def open(self) -> None:
        """Take the numbers as they are."""
        self.plant_in: int = int(self.plant_in)
        self.plant_out: int = int(self.plant_out)

    def host_us(self) -> int:
        """The host's clock [us]; `monotonic` goes in steps of 16 ms on Windows."""
        return time.perf_counter_ns() // 1000

    def readable(self, us: int, sending: bool) -> bool:
        """Whether bytes came within so many microseconds; ends early where some may be sent."""
        return bool(select.select([0], [1] if sending else [], [], us * 1e-6)[0])

    def read_line(self) -> bytes:
        """Return the bytes that have arrived."""
        return os.read(0, 1024)

    def send(self, data: bytes) -> int:
        """Give the line as much as it takes at once; how many bytes."""
        if not select.select([], [1], [], 0)[1]:
            return 0
        return os.write(1, data[: hal_pipe.PIECE])

    def read_plant(self, size: int) -> bytes:
        """The plant's answer, whole."""
        data = b""
        while len(data) < size:
            chunk = os.read(self.plant_in, size - len(data))
            if not chunk:
                break
            data += chunk
        return data

    def write_plant(self, data: bytes) -> None:
        """Tell the plant."""
        os.write(self.plant_out, data)

    def keep(self, path: str, data: bytes) -> None:
        """Write a file and have it on the disk."""
        with open(path, "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())


class SocketHal(Hal):
    """The line and the plant as two connections, each opened with the host's token."""

    def open(self) -> None:
        """Call the host twice."""
        port, token = int(str(self.plant_in).split(":")[1]), str(self.plant_out)
        self.line, self.plant = (self.connect(port, token + letter) for letter in "LP")
        self.line.setblocking(False)

    def connect(self, port: int, greeting: str):
        """A connection to the host."""
        connection = socket.create_connection(("127.0.0.1", port), 15.0)
        connection.settimeout(None)
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        connection.sendall(greeting.encode())
        return connection

    def readable(self, us: int, sending: bool) -> bool:
        """Whether bytes came within so many microseconds; ends early where some may be sent."""
        line = [self.line]
        return bool(select.select(line, line if sending else [], [], us * 1e-6)[0])

    def read_line(self):
        """Return the bytes that have arrived, None if none have; a lost host ends the board."""
        try:
            return self.line.recv(1024)
        except BlockingIOError:
            return None
        except ConnectionError:
            return b""

    def send(self, data: bytes) -> int:
        """Give the line as much as it takes at once; how many bytes."""
        try:
            return self.line.send(data[: hal_pipe.PIECE])
        except (BlockingIOError, ConnectionError):
            return 0

    def read_plant(self, size: int) -> bytes:
        """The plant's answer, whole."""
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
        """Tell the plant; without one the board ends."""
        try:
            self.plant.sendall(data)
        except ConnectionError:
            raise EOFError from None
