"""A bench behind VISA: `visa:TCPIP::10.0.0.7::5025::SOCKET`, `visa:ASRL/dev/ttyACM0::INSTR`.

PyVISA takes the VISA library that is installed, else its own in Python.
"""

from __future__ import annotations

from typing import Any

from layerjam.errors import FileError, MissingExtraError
from layerjam.rig.address import Address

TIMEOUT = 5000
"""Milliseconds that an answer is waited for."""


class VisaEnds:
    """A VISA resource, used like a connected socket; errors are OSError."""

    def __init__(self, address: Address) -> None:
        with MissingExtraError.without("a VISA address", "visa"):
            import pyvisa
        self._error: type[Exception] = pyvisa.Error
        try:
            self._manager: Any = pyvisa.ResourceManager()
        except (OSError, ValueError) as error:
            raise FileError(str(address), f"there is no VISA library: {error}") from None
        try:
            self._resource: Any = self._manager.open_resource(
                address.where, read_termination="\n", write_termination="\n", timeout=TIMEOUT
            )
        except (pyvisa.Error, OSError, ValueError, AttributeError) as error:
            self._manager.close()
            raise FileError(str(address), f"nobody answers: {error}") from None

    def sendall(self, data: bytes) -> None:
        """Send all of it."""
        try:
            self._resource.write_raw(data)
        except self._error as error:
            raise OSError(str(error)) from None

    def recv(self, _most: int) -> bytes:
        """What comes up to the next LF, or to the end of a message."""
        try:
            return bytes(self._resource.read_raw())
        except self._error as error:
            raise OSError(str(error)) from None

    def close(self) -> None:
        """Leave."""
        self._resource.close()
        self._manager.close()
