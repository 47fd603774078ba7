"""Checks of a chosen design: strength of the sheets, and the effect of scatter in friction."""

from collections.abc import Iterator, Mapping

from layerjam.design.robust import Chance
from layerjam.device.file import BrakeFile
from layerjam.mechanics.limits import sheet_stress
from layerjam.mechanics.pull import peak
from layerjam.units import show
from layerjam.verdict import Check, check

LIKELY = 0.5
"""Probability of meeting all constraints, with scatter in friction, below which a check notes it.
"""


def design_checks(file: BrakeFile, vacuum: float, chances: Mapping[str, Chance]) -> Iterator[Check]:
    """Return the checks of a design at its vacuum [Pa]; `chances` are those of `robustness`."""
    brake, limit = file.brake, file.brake.film.strength
    force = float(peak(vacuum, brake.sheets.usable_travel, brake).force)
    stress = float(sheet_stress(force, brake))
    words = f"at {show(force, 'N')} the stress in the sheets is {show(stress, 'Pa')}"
    if limit is None:
        yield check("sheet strength", False, f"{words}; the film's strength is not known")
    else:
        words += f" of {show(limit, 'Pa')}"
        yield check("sheet strength", stress <= limit, words, ": they stretch or tear", "failed")
    if "all" in chances:
        share = chances["all"].probability
        words = f"with the scatter in friction all constraints hold in {share:.0%} of brakes"
        yield check("scatter", share >= LIKELY, words)
