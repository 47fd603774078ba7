"""`lab`: practice files of a whole campaign, from a stated truth and a machine with faults."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from layerjam.commands.answer import Answer, si
from layerjam.device.load import write_whole
from layerjam.errors import QuantityError
from layerjam.lab.campaign import campaign
from layerjam.lab.campaign_files import commands, write_campaign
from layerjam.lab.spec import Spec
from layerjam.lab.text import example, spec_text
from layerjam.units import QuantitySpec

_SEED = QuantitySpec("1", "seed", hi=2**63 - 1, whole=True)


PRACTICE = "practice"
"""Name of the campaign that is built in."""


def lab_example(out: str | Path | None = None, *, force: bool = False) -> str:
    """The built-in campaign as commented TOML to edit; written to the file `out` if it is given.

    Raises FileError where that exists and `force` is not set.
    """
    text = spec_text(example())
    if out is not None:
        if Path(out).suffix != ".toml":
            raise QuantityError(f"out: '{out}' does not end in .toml")
        write_whole(out, lambda place: _fill(place, text), force)
    return text


def _fill(place: Path, text: str) -> None:
    place.write_text(text, encoding="utf-8", newline="\n")


def lab(
    spec: str | Path | Spec,
    *,
    out: str | Path,
    seed: int | None = None,
    force: bool = False,
    progress: Callable[[str, float], None] | None = None,
) -> Answer:
    """Write the files of a campaign into the folder `out`, with the truth beside them.

    `spec` is the path of a TOML file, a Spec, or "practice", which is built in; `seed` counts
    instead of its own. Every file says that it is synthetic. `progress` is told (what, share done);
    stopped by the keyboard, the files written are whole and the answer says so. `record` is the
    Campaign. Raises FileError where `out` is not empty and `force` is not set.
    """
    if seed is not None:
        seed = int(si(seed, _SEED, "seed"))
    built_in = not isinstance(spec, Spec) and str(spec) == PRACTICE and not Path(spec).exists()
    made = campaign(example() if built_in else spec, seed)
    written = write_campaign(made, out, force, progress)
    warnings = ["the files are synthetic: written by a program, not measured"]
    if written.stopped:
        warnings.append(
            f"stopped: {len(written.files)} of {len(made.tests)} files were written; those are "
            "whole"
        )
    if written.strangers:
        one = written.strangers == 1
        warnings.append(
            f"{written.strangers} other {'file' if one else 'files'} in {written.folder} "
            f"{'is' if one else 'are'} not of this campaign; "
            f"{'it was' if one else 'they were'} there before"
        )
    return Answer(
        values={
            "folder": str(written.folder),
            "files": [str(p) for p in written.files],
            "friction_tests": sum(1 for t in made.tests if t.kind == "friction"),
            "pulls": sum(1 for t in made.tests if t.kind == "pull"),
            "samples": written.samples,
            "faulty": sum(1 for t in made.tests if t.practice),
            "seed": made.spec.seed,
            "truth": str(written.folder / "truth.toml"),
            "next": commands(made, written.folder),
            "stopped": written.stopped,
        },
        units=dict.fromkeys(("friction_tests", "pulls", "samples", "faulty", "seed"), "1"),
        warnings=warnings,
        record=made,
    )
