"""A campaign's folder: the files a machine would leave, the truth beside them, what to do next."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from layerjam._version import __version__
from layerjam.device.load import write_whole
from layerjam.errors import FileError, count_of
from layerjam.lab import faults
from layerjam.lab.campaign import Campaign
from layerjam.lab.exports import Form, file_bytes, write_pair
from layerjam.lab.plan import Subject, Trial
from layerjam.lab.records import possible
from layerjam.lab.spec import Spec
from layerjam.lab.text import spec_text
from layerjam.measure.sidecar import sidecar_path
from layerjam.measure.trace import Trace
from layerjam.records.writer import literal
from layerjam.units import exact_text

SATURATED_AT = 0.8
"""Part of the greatest force at which the practice fault's load cell ends."""
Progress = Callable[[str, float], None]


@dataclass(frozen=True, kw_only=True)
class Written:
    """What was written: data files in the campaign's order, samples in them, whether stopped."""

    folder: Path
    files: tuple[Path, ...]
    samples: int
    stopped: bool
    strangers: int
    """Other files that lie in the folder, from before."""


def form_of(campaign: Campaign, test: Trial) -> Form:
    """The form of a test's file; each test takes the next layout."""
    forms = campaign.spec.files.forms()
    return forms[test.number % len(forms)]


def name_of(campaign: Campaign, test: Trial) -> str:
    """The name of a test's file."""
    return test.name + form_of(campaign, test).made.ending


def write_campaign(
    campaign: Campaign, folder: str | Path, force: bool = False, progress: Progress | None = None
) -> Written:
    """Write all files of a campaign, each whole or not at all; the same bytes for the same spec.

    A folder that is not empty is refused unless `force`. `progress` is called with (what, share);
    KeyboardInterrupt ends the writing between two files. Raises FileError, and QuantityError for
    a campaign that cannot be, before anything is written.
    """
    folder = Path(folder)
    tell = progress or (lambda _what, _share: None)
    possible(campaign.spec, campaign.tests)
    _prepare(folder, force)
    texts = {
        "README.txt": readme(campaign, folder),
        "spec.toml": "# SYNTHETIC: the campaign that made the files beside this one.\n"
        + spec_text(_portable(campaign)),
        "truth.toml": truth_text(campaign),
    }
    texts |= {brake_of(s): s.copied for s in campaign.subjects if s.copied}
    done: dict[int, Path] = {}
    samples, stopped = 0, False
    try:
        for name, text in texts.items():
            write_whole(folder / name, text, force)
        for test, trace in campaign.each():
            done[test.number] = _write(campaign, test, trace, folder, force)
            samples += len(trace)
            tell("writing files", len(done) / len(campaign.tests))
    except KeyboardInterrupt:
        stopped = True
    expected = {name_of(campaign, t) for t in campaign.tests}
    expected |= {f"{name}.toml" for name in expected} | {*texts}
    strangers = sum(1 for p in folder.iterdir() if p.name not in expected)
    files = tuple(done[n] for n in sorted(done))
    return Written(
        folder=folder, files=files, samples=samples, stopped=stopped, strangers=strangers
    )


def _prepare(folder: Path, force: bool) -> None:
    try:
        if folder.exists() and not folder.is_dir():
            raise FileError(folder, "is a file, not a folder")
        folder.mkdir(parents=True, exist_ok=True)
        if any(folder.iterdir()) and not force:
            raise FileError(folder, "is not empty; --force writes into it all the same")
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise FileError(str(folder)[:200], f"cannot be written: {reason}") from None


def _write(campaign: Campaign, test: Trial, trace: Trace, folder: Path, force: bool) -> Path:
    form, fault, cut = form_of(campaign, test), test.practice, None
    path = folder / name_of(campaign, test)
    if fault == "cut_off":
        draw = float(faults.generator(campaign.spec.seed, "practice", test.number + 1).random())
        cut = 0.3 + 0.65 * draw
    elif fault == "header_only":
        none = np.empty(0)
        trace = replace(trace, force=none, elongation=none, time=none)
    elif fault == "negative_force":
        trace = replace(trace, force=-trace.force)
    elif fault == "saturated":
        end = float(np.round(trace.force.max() * SATURATED_AT, 1))
        trace = replace(trace, force=np.minimum(trace.force, end))
    data = file_bytes(trace, form, "kN" if fault == "wrong_unit" else "N", cut)
    if fault == "no_sidecar" and force:
        sidecar_path(path).unlink(missing_ok=True)
    return write_pair(trace, path, data, force, sidecar=fault != "no_sidecar")


def brake_of(subject: Subject) -> str:
    """The brake as a spec in the campaign's folder names it."""
    return f"brake-{subject.label}.toml" if subject.copied else subject.name


def _portable(campaign: Campaign) -> Spec:
    """The spec with brakes that are found from the campaign's folder."""
    brakes = tuple(replace(s.truth, brake=brake_of(s)) for s in campaign.subjects)
    return replace(campaign.spec, brakes=brakes)


def truth_text(campaign: Campaign) -> str:
    """The truth of a campaign as TOML: of each brake, and of each file."""
    lines = [
        f"# SYNTHETIC, layerjam {__version__} virtual laboratory, seed {campaign.spec.seed}.",
        "# What the files beside this one were made from: solve the exercise first, then look.",
        "synthetic = true",
        f"seed = {campaign.spec.seed}",
    ]
    compliance = campaign.spec.machine.compliance
    rows = [("brakes", _truth_of(subject, compliance)) for subject in campaign.subjects]
    rows += [("tests", _truth_of_test(test, name_of(campaign, test))) for test in campaign.tests]
    for table, values in rows:
        lines += ["", f"[[{table}]]"]
        lines += [f"{key} = {literal(v)}" for key, v in values.items() if v is not None]
    return "\n".join([*lines, ""])


def _truth_of(subject: Subject, compliance: float) -> dict[str, Any]:
    """What fits should find, SI texts; means over the campaign's scatter."""
    true, known, truth = subject.true, subject.known, subject.truth
    stiffness = float(true.stiffness_measured or 0.0)
    seen = 1 / (1 / stiffness + compliance)
    exponent = true.pressure_exponent
    return {
        "label": subject.label,
        "brake": brake_of(subject),
        "scale_factor": true.scale_factor,
        "static": true.film.static,
        "kinetic": true.film.kinetic,
        "ageing": true.film.ageing,
        "static_hold": _seconds(true.film.static_hold),
        "friction_product": true.scale_factor * true.film.kinetic,
        # what `calibrate` finds with the friction of the brake's own file
        "scale_factor_with_known_friction": true.scale_factor
        * true.film.kinetic
        / known.film.kinetic,
        "stiffness": exact_text(stiffness, "N/m"),
        "stiffness_with_machine": f"{seen:.9g} N/m",
        "enclosure_factor": truth.enclosure_factor,
        "pressure_exponent": exponent,
        "test_pressure": None if exponent is None else exact_text(true.test_pressure or 0.0, "Pa"),
        "speed_slope": truth.speed_slope,
        "speed_reference": exact_text(truth.speed_reference, "m/s"),
    }


def _truth_of_test(test: Trial, file: str) -> dict[str, Any]:
    """What was so in one test."""
    pull = test.kind == "pull"
    return {
        "file": file,
        "kind": test.kind,
        "repeat": test.repeat,
        "true_vacuum": None if test.true_vacuum is None else exact_text(test.true_vacuum, "Pa"),
        "friction_factor": test.friction,
        "static_factor": None if pull else test.static,
        "stiffness_factor": test.stiffness if pull else None,
        "enclosure_factor": test.enclosure if pull else None,
        "hold": _seconds(test.hold),
        "warmer": f"{test.warmer:.4g} K",
        "practice_fault": test.practice or None,
        "odd": test.odd or None,
        "overshoot": test.overshoot or None,
        "seating": exact_text(test.seating, "m") if test.seating else None,
        "true_speed": exact_text(test.true_speed, "m/s") if pull and test.odd else None,
    }


def _seconds(value: float | None) -> str | None:
    return None if value is None else exact_text(value, "s")


def commands(campaign: Campaign, folder: Path) -> list[str]:
    """Commands to try on the files, brake by brake."""
    out = []
    for subject in campaign.subjects:
        brake = shlex.quote(str(folder / brake_of(subject)) if subject.copied else subject.name)
        mine = shlex.quote(str(folder / f"{subject.label}-tested.toml"))
        fitted = shlex.quote(str(folder / f"{subject.label}-calibrated.toml"))
        tests = [t for t in campaign.tests if t.subject is subject]
        sleds = [t for t in tests if t.kind == "friction"]
        if sleds:
            found = _patterns(campaign, folder, sleds)
            if spec_holds := campaign.spec.friction.holds:
                aged = shlex.quote(str(folder / f"{subject.label}-aged.toml"))
                held = f"--hold {max(spec_holds):g}s"
                out.append(f"layerjam ageing {found} {held} --brake {brake} --out {aged}")
            out.append(f"layerjam friction {found} --brake {brake} --out {mine}")
            brake = mine
        pulls = [t for t in tests if t.kind == "pull"]
        if pulls:
            most = max(t.vacuum or 0.0 for t in pulls)
            some = [t for t in pulls if t.vacuum == most]
            others = [t for t in pulls if t.vacuum != most]
            found = _patterns(campaign, folder, some)
            out.append(f"layerjam calibrate {brake} {found} --out {fitted}")
            if others:
                found = _patterns(campaign, folder, others)
                out.append(f"layerjam validate {fitted} {found}")
    return out


def _patterns(campaign: Campaign, folder: Path, tests: Sequence[Trial]) -> str:
    """Patterns of a shell that name the files of some tests, all speeds, and no sidecar."""
    names = {}
    for test in tests:
        # all repeats, and of pulls all speeds
        parts = test.name.split("_")[: 3 if test.kind == "pull" else 2]
        names["_".join([*parts, "*"]) + form_of(campaign, test).made.ending] = test
    return " ".join(f"{shlex.quote(str(folder))}/{name}" for name in names)


def readme(campaign: Campaign, folder: Path) -> str:
    """What the folder holds, for whoever finds it."""
    tests, spec = campaign.tests, campaign.spec
    sleds = sum(1 for t in tests if t.kind == "friction")
    faulty = sum(1 for t in tests if t.practice)
    lines = [
        "SYNTHETIC. Nothing here was measured.",
        f"Written by the virtual laboratory of layerjam {__version__}, seed {spec.seed}.",
        "",
        f"{count_of(sleds, 'friction test')} and {count_of(len(tests) - sleds, 'pull')}, in these "
        f"layouts: {', '.join(spec.files.layouts)}.",
        "Beside each file NAME stands NAME.toml with what the file does not say itself: vacuum,",
        "speed, repeat, brake.",
        "spec.toml is the campaign; layerjam lab spec.toml --out ANOTHER writes it again.",
        "truth.toml holds what the files were made from. Solve the exercise first, then look.",
    ]
    if faulty:
        lines += [
            f"{faulty} of the pulls' files have a fault that a reader should find. Files that are",
            "refused are listed; --partial writes the brake from the others.",
        ]
    lines += ["", "To try:", *(f"  {c}" for c in commands(campaign, folder)), ""]
    return "\n".join(lines)
