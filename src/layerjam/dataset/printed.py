"""Numbers, text and looks of published pages and PDFs."""

import html
import importlib.util
import re
from typing import Any

NUMBER = re.compile(r"(?<![\w.])([-−]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)(?!\w|\.\w)")
"""A number that is not part of a word, a digest or a version."""
_HIDDEN = re.compile(r"<(style|script|svg|title)\b.*?</\1>|<!--.*?-->", re.DOTALL)
_SHOWN = re.compile(r"<!--(.*?)-->", re.DOTALL)
DPI = 100.0
SHADES = 48
"""Largest difference of two points of a page, of 255, that is ignored: edges shift."""


def reads_pdf() -> bool:
    """Whether the library that reads PDFs is installed."""
    return importlib.util.find_spec("pypdfium2") is not None


def numbers(file: str, content: bytes) -> list[float]:
    """Return the numbers that a reader of a file sees, in order; a drawing's words are comments."""
    if file.endswith(".pdf"):
        text = "\n".join(pdf_pages(content) or ())
    elif file.endswith(".svg"):
        text = "\n".join(_SHOWN.findall(content.decode()))
    else:
        text = html.unescape(re.sub(r"<[^>]*>", " ", _HIDDEN.sub(" ", content.decode())))
    return [float(text_.replace("−", "-")) for text_ in NUMBER.findall(text)]


def pdf_pages(content: bytes) -> list[str] | None:
    """Return the text of each page, or None for bytes that are not a PDF."""
    import pypdfium2

    try:
        with pypdfium2.PdfDocument(content) as document:
            return [_page_text(document[n]) for n in range(len(document))]
    except pypdfium2.PdfiumError:
        return None


def _page_text(page: Any) -> str:
    return str(page.get_textpage().get_text_range()).replace("\r\n", "\n")


def other_looks(old: bytes, new: bytes) -> int | None:
    """Return the first page (from 1) on which two PDFs of equal text look different, or None."""
    import numpy as np
    import pypdfium2

    with pypdfium2.PdfDocument(old) as before, pypdfium2.PdfDocument(new) as after:
        for number in range(len(before)):
            pages = (before[number], after[number])
            pair = [page.render(scale=DPI / 72).to_numpy().astype(int) for page in pages]
            if pair[0].shape != pair[1].shape or np.abs(pair[0] - pair[1]).max() > SHADES:
                return number + 1
    return None
