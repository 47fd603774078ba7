"""Comparison of two PDFs from Typst, object by object, and the text of their pages."""

import re
import zlib
from collections.abc import Iterator
from typing import Any

from layerjam.laboratory.dataset.text_comparison import DRAWN, NUMBER, Difference, diff_texts

LARGEST = 2**28
"""Largest unpacked size of one stream [bytes]."""
_OBJECT = re.compile(rb"(\d+ \d+ obj\n.*?\nendobj\n)", re.DOTALL)
_DERIVED = re.compile(
    r"(?<=xref\n)\d+ \d+\n(?:\d{10} \d{5} [fn]..)*(?=trailer\n)|(?<=startxref\n)\d+|"
    r"(?<=/ID\[)(?:\([\w+/=]*\))*(?=\])|(?<=/Length )\d+|(?<=ID>)[\w+/=]*(?=</xmpMM:)",
    re.DOTALL,
)
"""Positions and lengths of the objects, and digests of the content."""
_PLACES = {"m": 2, "l": 2, "c": 6, "v": 4, "y": 4, "re": 4, "cm": 2, "Tm": 2}
"""{operator: number of its last operands that are coordinates}."""
_WORD = re.compile(r"\s*([A-Za-z]+)")


def diff_pdfs(file: str, old: bytes, new: bytes) -> Iterator[Difference]:
    """Yield the differences of two PDFs: in the text of the pages or, if none, in an object.

    Coordinates may differ by DRAWN and other numbers as in texts; everything else must be equal,
    including metadata, attachments and bytes between or after the objects.
    """
    pages = read_pdf_pages(old), read_pdf_pages(new)
    if None not in pages:
        left, right = ("\n".join(page or ()) for page in pages)
        texts = list(diff_texts(file, left, right))
        yield from texts
        if texts:
            return
    before, after = _split_objects(old), _split_objects(new)
    if before is None or after is None:
        yield Difference("text", file, "cannot be read", None)
    elif len(before) != len(after):
        yield Difference("number of objects", file, len(before) // 2, len(after) // 2)
    else:
        for left, right in zip(before, after, strict=True):
            first = next(diff_texts(file, left, right, _list_margins), None)
            if first is not None:
                place = left.partition("\n")[0][:30] or "bytes between the objects"
                name = f"{place}: {first.number}"
                yield Difference(name, file, first.published, first.recomputed, first.share)
                return


def _split_objects(content: bytes) -> list[str] | None:
    """Return the objects of a PDF, unpacked, with the bytes before, between and after them.

    Returns None if a stream cannot be unpacked.
    """
    try:
        return [_unpack(piece) for piece in _OBJECT.split(content)]
    except zlib.error:
        return None


def _unpack(piece: bytes) -> str:
    head, mark, content = piece.partition(b"stream\n")
    data, end, tail = content.rpartition(b"\nendstream")
    if b"/FlateDecode" in head and mark:
        stream = zlib.decompressobj()
        data = stream.decompress(data, LARGEST)
        tail = stream.unconsumed_tail + stream.unused_data + tail
    return _DERIVED.sub("", (head + mark + data + end + tail).decode("latin-1"))


def _list_margins(text: str) -> Iterator[float]:
    """Yield DRAWN for each coordinate in a page's content, and 0 for other numbers."""
    pieces = NUMBER.split(text)
    count = len(pieces) // 2
    rooms = [0.0] * count
    for index in range(count):
        word = _WORD.match(pieces[2 * index + 2])
        if word is not None and word[1] in _PLACES:
            begin = index + 1 - _PLACES[word[1]]
            rooms[max(begin, 0) : index + 1] = [DRAWN] * (index + 1 - max(begin, 0))
        elif pieces[2 * index].endswith("/BBox["):
            rooms[index : index + 4] = [DRAWN] * len(rooms[index : index + 4])
    return iter(rooms)


def read_pdf_pages(content: bytes) -> list[str] | None:
    """Return the text of each page, or None for bytes that are not a PDF."""
    import pypdfium2

    try:
        with pypdfium2.PdfDocument(content) as document:
            return [_read_page_text(document[n]) for n in range(len(document))]
    except pypdfium2.PdfiumError:
        return None


def _read_page_text(page: Any) -> str:
    return str(page.get_textpage().get_text_range()).replace("\r\n", "\n")
