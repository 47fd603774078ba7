"""Pages as PDF, typeset by typst: a report from the data of its HTML page, or other templates."""

import json
import tempfile
from collections.abc import Mapping
from datetime import UTC, datetime
from importlib.resources import files
from pathlib import Path
from typing import Any

from layerjam.errors import MissingExtraError

NO_DATE = datetime(1980, 1, 1, tzinfo=UTC)
"""Default date of a PDF, fixed so that its bytes do not depend on the day."""


def typeset_pdf(data: Mapping[str, Any], pictures: Mapping[str, str]) -> bytes:
    """Return a report's bytes; the same content and date produce the same bytes.

    `data` is the result of Page.template_data, with a `date` (ISO) and a `command`; `pictures` the
    figures' SVG by name.
    """
    date = datetime.fromisoformat(str(data["date"])).replace(tzinfo=UTC)
    return typeset_file("page", data, {f"{name}.svg": svg for name, svg in pictures.items()}, date)


def typeset_file(
    template: str,
    data: Mapping[str, Any],
    pictures: Mapping[str, str | bytes] | None = None,
    date: datetime = NO_DATE,
) -> bytes:
    """Return the bytes of a PDF set from a template next to this file, such as page.typ.

    The template reads `data` from data.json, and `pictures` by file name. Only the fonts of typst
    are used, so that a page does not depend on the machine's fonts.
    """
    with MissingExtraError.raise_if_missing("a page as PDF (typst)", "pdf"):
        import typst
    text = (files("layerjam.report") / f"{template}.typ").read_text(encoding="utf-8")
    inputs: dict[str, str | bytes] = {**(pictures or {}), "main.typ": text}
    with tempfile.TemporaryDirectory() as folder:
        for name, content in (inputs | {"data.json": json.dumps(data)}).items():
            raw = content if isinstance(content, bytes) else content.encode()
            (Path(folder) / name).write_bytes(raw)
        main = str(Path(folder) / "main.typ")
        options: dict[str, Any] = {"root": folder, "ignore_system_fonts": True, "timestamp": date}
        return bytes(typst.compile(input=main, format="pdf", **options))
