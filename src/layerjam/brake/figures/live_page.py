"""Part of a page that computes a brake in the reader's browser, by the C kernel as WebAssembly."""

import base64
import html
import json
from dataclasses import asdict
from typing import Any

from layerjam.brake.device.brake_file import BrakeFile
from layerjam.brake.figures.device_drawing import make_shape, read_asset
from layerjam.brake.kernel.parameters import check_exportable, parameters
from layerjam.brake.kernel.web import read_module
from layerjam.brake.simulate.least_vacuum import GRID, LEVELS, MARGIN
from layerjam.core.drawing.page import Live
from layerjam.core.errors import QuantityError

STYLES = ("brake_drawing.css", "live_page.css")
SCRIPTS = ("brake_drawing.js", "live_kernel.js", "live_chart.js", "live_page.js")
NOT_OFFERED = (
    "“Try it” is not offered for this brake, because the page's C kernel lacks its law: {}."
)


def find_missing_law(file: BrakeFile) -> str | None:
    """Return the law of a brake that the C kernel lacks, as a sentence, or None."""
    try:
        check_exportable(file)
    except QuantityError as error:
        return str(error)
    return None


def make_live(file: BrakeFile, rope_stiffness: float | None = None) -> Live:
    """Return the part for a brake, with a rope [N/m] in series, or the reason why there is none.

    Raises CompilerError if the kernel's sources changed and cannot be compiled here.
    """
    if (reason := find_missing_law(file)) is not None:
        return Live(f'<p class="banner">{html.escape(NOT_OFFERED.format(reason))}</p>')
    data = json.dumps(_make_data(file, rope_stiffness), separators=(",", ":"))
    style, code = ("".join(map(read_asset, names)) for names in (STYLES, SCRIPTS))
    return Live(read_asset("live_page.html"), style, f"const DATA = {data};\n{code}")


def _make_data(file: BrakeFile, rope_stiffness: float | None) -> dict[str, Any]:
    brake = file.brake
    return {
        "module": base64.b64encode(read_module()).decode(),
        "numbers": [*parameters(file, rope_stiffness)],
        "full": brake.site.atmosphere,
        "end": brake.sheets.usable_travel,
        "gravity": brake.site.gravity,
        "margin": MARGIN,
        "search": {"levels": LEVELS, "grid": GRID},
        "shape": asdict(make_shape(brake)),
    }
