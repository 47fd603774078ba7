"""Films that each cutter may cut: in the wrong film, a laser releases toxic gas."""

from collections.abc import Sequence

from layerjam.brake.device.brake_file import BrakeFile
from layerjam.core.errors import QuantityError
from layerjam.core.toml_files.source import Source
from layerjam.workshop.fabricate.verdicts import Check, finding

PUNCHED_BELOW = 5.0
"""Hole diameter [mm] below which a punch is needed: a plotter knife cannot cut the hole round."""
OWN_KINDS = ("measured", "assumed", "unstated")
"""Kinds of source that are not published."""
ADVICE = {
    "never": "never cut this film with a laser; use a blade, shears or a die",
    "with care": "a laser may cut this film only with care: extract the fumes and clean the edge",
    "yes": "a laser may cut this film; extract the fumes",
}


def laser_check(file: BrakeFile, cutter: str) -> Check:
    """Return C15: whether this cutter may cut the film.

    Raises QuantityError if a laser is to cut a film that has no laser data, or whose data have no
    source.
    """
    word, source = file.making.film.laser, file.sources.get("film.laser", Source())
    if cutter != "laser":
        advice = ADVICE[word] if word else "no laser-cutting data for this film"
        who = "tell the service: " if cutter == "service" and word in (None, "never") else ""
        return finding("C15", "film-and-laser", who + advice)
    if word is None:
        raise QuantityError.of(
            "film.laser",
            "is not given, and some films release poisons when cut (PTFE: carbonyl fluoride, PVC "
            "and vinyl: chlorine); identify the film and write laser = { value = "
            '"never", "with care" or "yes", source = "..." } in [film], or use a different cutter',
        )
    if word != "never" and not source.text:
        raise QuantityError.of(
            "film.laser",
            f"'{word}' has no source; write laser = {{ value = \"{word}\", kind = "
            '"measured", source = "..." } and state there how the fumes are removed',
        )
    text = f"{ADVICE[word]} ({source.sentence()})"
    return finding("C15", "film-and-laser", text, passes=word != "never", otherwise="refused")


def cutter_notes(file: BrakeFile, cutter: str) -> Sequence[str]:
    """Return the sentences, one line each, that are written to every file for a cutter."""
    word, source = file.making.film.laser, file.sources.get("film.laser", Source())
    text, old_text = " ".join(source.text.split()), " ".join(source.was.split())
    if word == "never":
        return ["Never cut this film with a laser."]
    if cutter == "laser" and old_text.startswith("never"):
        return [f"WARNING: the catalogue says {old_text}", f"Overridden by: {text}"]
    if cutter == "laser" and source.kind in OWN_KINDS:
        return [f"The owner states that a laser may cut this film: {text}"]
    return []
