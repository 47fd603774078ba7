"""Files of one campaign by use: friction tests, pulls for calibration and for validation."""

import re
from collections.abc import Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Annotated

from layerjam.brake.simulate.quantities import VACUUM
from layerjam.core.command.declare import Help, Progress, options
from layerjam.core.errors import FitError, LayerjamError, QuantityError
from layerjam.core.units import QuantitySpec, show
from layerjam.laboratory.commands.reading import FileOptions, Measured, list_files
from layerjam.laboratory.measure.trace import Trace

SPEED = QuantitySpec("m/s", "crosshead speed", open_lo=True)
SAME_SHARE = 0.03
"""Relative tolerance between a reserved and the measured vacuum or speed."""
Paths = Sequence[Measured] | Measured


@options
class Measurements:
    """Files of a report, and the use of each."""

    friction: Annotated[Paths, Help("Friction tests.", metavar="FILE...", greedy=True)] = ()
    pulls: Annotated[Paths, Help("Pulls to calibrate on.", metavar="FILE...", greedy=True)] = ()
    validate: Annotated[Paths, Help("Pulls to validate on.", metavar="FILE...", greedy=True)] = ()
    calibrate_on: Annotated[
        Paths,
        Help(
            "Calibrate on these only; validate on the other pulls.",
            metavar="FILE...",
            greedy=True,
        ),
    ] = ()
    holdout: Annotated[
        Sequence[str],
        Help(
            "Reserve the pulls at this vacuum, speed or 'repeat N' for the validation.",
            metavar="Q...",
            greedy=True,
        ),
    ] = ()

    def split_pulls(
        self, reading: FileOptions, progress: Progress
    ) -> tuple[Sequence[Measured], Sequence[Measured]]:
        """Return the pulls for calibration and those for validation."""
        pulls, others = list_files(self.pulls), list_files(self.validate)
        choice = list_files(self.calibrate_on)
        holdout = [self.holdout] if isinstance(self.holdout, str) else list(self.holdout)
        if choice and holdout:
            raise QuantityError("--calibrate-on and --holdout: give only one of them")
        if holdout and not pulls:
            raise QuantityError("--holdout: requires --pulls, from which it reserves some")
        if holdout:
            calibration, held_back = _split_holdout(pulls, holdout, reading, progress)
            return calibration, [*held_back, *others]
        if choice:
            identities = {_source_identity(p) for p in choice}
            others_left = [p for p in pulls if _source_identity(p) not in identities]
            if not (others_left or others):
                raise QuantityError(
                    "--calibrate-on: names every pull, so none is left to validate on"
                )
            return choice, [*others_left, *others]
        return pulls, others or pulls


def _source_identity(source: Measured) -> str:
    return str(Path(source.path if isinstance(source, Trace) else source).resolve())


def _split_holdout(
    pulls: Sequence[Measured], holdout: Sequence[str], reading: FileOptions, progress: Progress
) -> tuple[list[Measured], list[Measured]]:
    """Return the pulls for calibration, and those at a vacuum, speed or repeat in `holdout`."""
    from layerjam.laboratory.identify.curves import crosshead_speed
    from layerjam.laboratory.measure.readers.read import read_trace

    conditions = [_parse_condition(text) for text in holdout]
    progress(f"reserving {', '.join(holdout)}", 0.05)
    kept_pulls: list[Measured] = []
    held_pulls: list[Measured] = []
    levels: set[float] = set()
    for source in pulls:
        try:
            trace = source if isinstance(source, Trace) else read_trace(source, reading)
        except LayerjamError:
            kept_pulls.append(source)  # the file will be rejected, with a reason, when it is used
            continue
        facts = asdict(replace(trace.facts, speed=crosshead_speed(trace)))
        if facts["vacuum"] is not None:
            levels.add(facts["vacuum"])
        is_held = any(_is_close(facts[quantity], value, quantity) for quantity, value in conditions)
        (held_pulls if is_held else kept_pulls).append(source)
    for side, word in ((kept_pulls, "to calibrate on"), (held_pulls, "reserved")):
        if not side:
            sentence = f"--holdout {', '.join(holdout)}: none of {len(pulls)} pulls is {word}"
            vacuums = ", ".join(show(level, "Pa") for level in sorted(levels))
            raise FitError(
                f"{sentence}; they state {f'vacuums of {vacuums}' if vacuums else 'no vacuum'}"
            )
    return kept_pulls, held_pulls


def _is_close(value: float | None, reference: float, quantity: str) -> bool:
    tolerance = 0.0 if quantity == "repeat" else SAME_SHARE * reference
    return value is not None and abs(value - reference) <= tolerance


def _parse_condition(text: str) -> tuple[str, float]:
    """Return ("vacuum", Pa), ("speed", m/s) or ("repeat", number) of the pulls to reserve."""
    match = re.fullmatch(r"\s*repeat\s*(\d{1,6})\s*", text)
    if match:
        return "repeat", float(match.group(1))
    for quantity, spec in (("vacuum", VACUUM), ("speed", SPEED)):
        try:
            return quantity, float(spec.read(text, "holdout"))
        except QuantityError:
            continue
    raise QuantityError(
        f"holdout: '{text[:60]}' is not a vacuum, speed or repeat; write, for example, 46.1kPa, "
        "19mm/s or 'repeat 3'"
    )
