"""Images for a Pico's boot loader: UF2, 256 bytes of flash in each block of 512.

The format is Microsoft's (github.com/microsoft/uf2); family and addresses are for the RP2040.
"""

import struct

from layerjam.core.errors import LayerjamError

RP2040 = 0xE48BFF56
FLASH = 0x10000000
FLASH_BYTES = 2 * 1024 * 1024
BLOCK, PAYLOAD = 512, 256
HEAD = "<8I"
FIRST, SECOND, LAST = 0x0A324655, 0x9E5D5157, 0x0AB16F30
HAS_FAMILY = 0x2000


class ImageError(LayerjamError):
    """Raised if a file is not an image for this board."""

    key = "image"


def encode_uf2(program: bytes, family: int) -> bytes:
    """Return the UF2 file of a program at the start of flash memory."""
    count = -(-len(program) // PAYLOAD)
    out = []
    for number in range(count):
        part = program[number * PAYLOAD : (number + 1) * PAYLOAD].ljust(PAYLOAD, b"\0")
        place = FLASH + number * PAYLOAD, PAYLOAD, number, count
        head = struct.pack(HEAD, FIRST, SECOND, HAS_FAMILY, *place, family)
        out.append((head + part).ljust(BLOCK - 4, b"\0") + struct.pack("<I", LAST))
    return b"".join(out)


def decode_uf2(image: bytes, family: int, name: str) -> bytes:
    """Return the program in a UF2 file; ImageError if it does not fit this board."""
    if not image or len(image) % BLOCK:
        raise ImageError(
            f"{name} is not a UF2 image: {len(image)} bytes, not a multiple of {BLOCK}"
        )
    count = len(image) // BLOCK
    program = bytearray()
    for number in range(count):
        block = image[number * BLOCK : (number + 1) * BLOCK]
        first, second, flags, address, size, place, blocks, kind = struct.unpack(HEAD, block[:32])
        if (first, second, block[-4:]) != (FIRST, SECOND, struct.pack("<I", LAST)):
            raise ImageError(f"{name} is not a UF2 image: block {number} lacks its markers")
        if not flags & HAS_FAMILY or kind != family:
            raise ImageError(f"{name} is for chip family {kind:#010x}, not {family:#010x}")
        if (place, blocks) != (number, count):
            raise ImageError(f"{name} is incomplete: block {place} of {blocks} at index {number}")
        if size != PAYLOAD or address != FLASH + number * PAYLOAD:
            raise ImageError(f"{name} does not fill the flash from its start: {address:#010x}")
        program += block[32 : 32 + size]
    if len(program) > FLASH_BYTES:
        raise ImageError(f"{name} has {len(program)} bytes, but the flash has {FLASH_BYTES}")
    return bytes(program)
