"""A page as PDF, set by typst from the same text as the HTML page."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Mapping
from datetime import UTC, datetime
from importlib.resources import files
from pathlib import Path
from typing import Any

from layerjam.errors import MissingExtraError


def pdf(shown: Mapping[str, Any], pictures: Mapping[str, str]) -> bytes:
    """The PDF's bytes; the same content on the same date gives the same bytes.

    `shown` is what Page.shown gives, with a `date` (ISO) and a `command`; `pictures` the figures'
    SVG by name. Fonts are those inside typst, so that no machine's fonts change a page.
    """
    with MissingExtraError.without("the report as PDF (typst)", "pdf"):
        import typst
    when = datetime.fromisoformat(str(shown["date"])).replace(tzinfo=UTC)
    template = (files("layerjam.report") / "page.typ").read_text(encoding="utf-8")
    with tempfile.TemporaryDirectory() as folder:
        inputs = {f"{name}.svg": svg for name, svg in pictures.items()}
        for name, text in (inputs | {"main.typ": template, "data.json": json.dumps(shown)}).items():
            (Path(folder) / name).write_text(text, encoding="utf-8")
        main = str(Path(folder) / "main.typ")
        how: dict[str, Any] = {"root": folder, "ignore_system_fonts": True, "timestamp": when}
        return bytes(typst.compile(input=main, format="pdf", **how))
