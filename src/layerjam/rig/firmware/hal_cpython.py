"""The same board of pipes under CPython, where there is no MicroPython."""

import os
import select
import time

import hal_pipe


class Hal(hal_pipe.Hal):
    """The pipes by their descriptors."""

    collects = False

    def open(self) -> None:
        """Take the numbers as they are."""
        self.plant_in: int = int(self.plant_in)
        self.plant_out: int = int(self.plant_out)

    def host_us(self) -> int:
        """The host's clock [us]."""
        return time.monotonic_ns() // 1000

    def readable(self, us: int, sending: bool) -> bool:
        """Whether bytes came within so many microseconds; ends early where some may be sent."""
        return bool(select.select([0], [1] if sending else [], [], us * 1e-6)[0])

    def read_line(self) -> bytes:
        """What the line has."""
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
            more = os.read(self.plant_in, size - len(data))
            if not more:
                break
            data += more
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
