"""Whether a film is sold as thick as a brake's sheets are, for a word of warning."""

from __future__ import annotations

from collections.abc import Iterator

from layerjam.device.file import BrakeFile
from layerjam.errors import Notice
from layerjam.units import show

NEAR = 0.1
"""Share by which a measured thickness may differ from the gauge it was bought as.

DuPont allows a Kapton HN film of 127 um 7 %, of 76 um 9 %, thinner ones more (GS-96-7).
"""


def unsold(file: BrakeFile) -> Iterator[Notice]:
    """A notice where the film's maker lists no such thickness; none where nothing is known."""
    gauges, thickness = file.making.film.gauges, float(file.brake.sheets.thickness)
    if not gauges or any(abs(thickness / gauge - 1) <= NEAR for gauge in gauges):
        return
    what = file.making.film.product or "this film"
    sold = ", ".join(show(gauge, "m", 3, like=min(gauges)) for gauge in sorted(gauges))
    yield Notice(
        f"{show(thickness, 'm')} is none of the thicknesses in which {what} is sold ({sold}): "
        "ask what was bought; a laminate, plies or another grade has another modulus, friction "
        "and edge",
        "film-gauge",
    )
