"""Warning about a brake whose film is not sold in the thickness of its sheets."""

from collections.abc import Iterator

from layerjam.brake.device.brake_file import BrakeFile
from layerjam.core.errors import Notice
from layerjam.core.units import show

TOLERANCE = 0.1
"""Allowed relative difference between a measured thickness and the nominal gauge.

DuPont allows 7 % for a Kapton HN film of 127 um, 9 % for 76 um and more for thinner ones (GS-96-7).
"""


def gauge_notices(file: BrakeFile) -> Iterator[Notice]:
    """Yield a notice if the film is not sold in this thickness.

    There is no notice if the available thicknesses are unknown.
    """
    gauges, thickness = file.making.film.gauges, float(file.brake.sheets.thickness)
    if not gauges or any(abs(thickness / gauge - 1) <= TOLERANCE for gauge in gauges):
        return
    product = file.making.film.product or "this film"
    sold = ", ".join(show(gauge, "m", 3, like=min(gauges)) for gauge in sorted(gauges))
    yield Notice(
        f"{product} is not sold {show(thickness, 'm')} thick (available: {sold}): check which film "
        "you bought; a laminate or a different grade differs in modulus, friction "
        "and edge",
        "film-gauge",
    )
