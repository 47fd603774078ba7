"""Frames on a serial line: session, number, payload and checksum; this file also runs on the board.

    @ S NN LLLL CCCCCCCC <space> payload LF

with no spaces except the one shown: S is the session, NN the number, L the length of the payload
and C the CRC-32 of "SNNLLLL" and the payload, all in upper-case hexadecimal. Each frame gets
exactly one response, with the same S and NN. An empty payload to the board ends the session.
"""

import binascii

HEAD = 17
"""Number of bytes before the payload."""
LONGEST = 0xFFFF
PENDING = b"\x05"
"""Response to a line that waits for a capture (*OPC?, *WAI); the host sends it to ask again."""
_HEX = b"0123456789ABCDEF"


def pack(session: int, number: int, payload: bytes) -> bytes:
    """Return the frame of a payload of at most 65,535 bytes, session 0 to 15, number 0 to 255."""
    head = b"%X%02X%04X" % (session, number, len(payload))
    check = binascii.crc32(payload, binascii.crc32(head))
    return b"".join((b"@", head, b"%08X " % check, payload, b"\n"))


def frame_length(head: bytes) -> int:
    """Return the payload length stated by a frame's first 17 bytes; -1 if they are invalid."""
    if len(head) != HEAD or head[0] != 64 or head[16] != 32:
        return -1
    for byte in head[1:16]:
        if byte not in _HEX:
            return -1
    return int(head[4:8], 16)


def unpack(frame: bytes) -> "tuple[int, int, bytes] | None":
    """Return (session, number, payload) of a complete frame with its LF; None if damaged."""
    size = frame_length(frame[:HEAD])
    if size < 0 or len(frame) != HEAD + size + 1 or frame[-1] != 10:
        return None
    payload = bytes(frame[HEAD:-1])
    check = binascii.crc32(payload, binascii.crc32(bytes(frame[1:8])))
    if check != int(frame[8:16], 16):
        return None
    return int(frame[1:2], 16), int(frame[2:4], 16), payload


def parse_first_frame(buffer: bytes) -> "tuple[tuple[int, int, bytes] | None, int]":
    """Return (first undamaged frame or None, number of bytes consumed).

    Bytes outside frames are skipped; an incomplete frame is not consumed.
    """
    place = 0
    while True:
        place = buffer.find(b"@", place)
        if place < 0:
            return None, len(buffer)
        head = buffer[place : place + HEAD]
        if len(head) < HEAD:
            return None, place
        size = frame_length(head)
        if size >= 0:
            end = place + HEAD + size + 1
            if len(buffer) < end:
                return None, place
            frame = unpack(buffer[place:end])
            if frame is not None:
                return frame, end
        place += 1
