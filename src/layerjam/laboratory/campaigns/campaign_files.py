"""A campaign's folder: the machine's files, the true values, and a README with the next steps."""

import contextlib
import os
import shutil
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from layerjam._version import __version__
from layerjam.core.errors import FileError, count_text
from layerjam.core.evolve import evolve
from layerjam.core.store import Appearing, store_file
from layerjam.core.system import check_file_name, quote_pattern, quote_word, report_failure
from layerjam.core.toml_files.folders import make_hidden_folder
from layerjam.core.toml_files.writer import literal
from layerjam.core.units import exact_text
from layerjam.laboratory.campaigns import faults
from layerjam.laboratory.campaigns.campaign import Campaign
from layerjam.laboratory.campaigns.exports import Form, encode_file, write_with_sidecar
from layerjam.laboratory.campaigns.plan import Subject, Trial
from layerjam.laboratory.campaigns.spec import Spec
from layerjam.laboratory.campaigns.text import format_spec
from layerjam.laboratory.campaigns.virtual_records import check_pulls
from layerjam.laboratory.measure.sidecar import sidecar_path
from layerjam.laboratory.measure.trace import Trace

SATURATED_AT = 0.8
"""Fraction of the maximum force at which the load cell saturates in the practice fault."""
Progress = Callable[[str, float], None]


@dataclass(frozen=True, kw_only=True)
class CampaignFiles:
    """Files of a campaign, in order, and the number of samples."""

    folder: Path
    files: tuple[Path, ...]
    samples: int
    strangers: int
    """Number of other files that already existed in the folder."""


def select_form(campaign: Campaign, test: Trial) -> Form:
    """Return the form of a test's file; the forms alternate from test to test."""
    forms = campaign.spec.files.list_forms()
    return forms[test.number % len(forms)]


def file_name(campaign: Campaign, test: Trial) -> str:
    """Return the name of a test's file."""
    return test.name + select_form(campaign, test).details.ending


def write_campaign(
    campaign: Campaign,
    folder: str | Path,
    overwrite: bool = False,
    progress: Progress | None = None,
) -> CampaignFiles:
    """Write all files of a campaign, or none if interrupted; equal specs give equal files.

    A folder that is not empty is rejected unless `overwrite`. `progress` is called with (stage,
    fraction). Raises FileError, and QuantityError for an impossible campaign, before anything is
    written.
    """
    folder = Path(folder)
    tell = progress or (lambda _what, _share: None)
    check_pulls(campaign.spec, campaign.tests)
    _prepare_folder(folder, overwrite)
    texts = {
        "README.txt": format_readme(campaign, folder),
        "spec.toml": "# SYNTHETIC: the campaign that created the files in this folder.\n"
        + format_spec(_make_portable(campaign)),
        "truth.toml": format_truth(campaign),
    }
    texts |= {brake_reference(s): s.file_text for s in campaign.subjects if s.file_text}
    samples, names_written = 0, {}
    with _make_draft(folder) as draft:
        for name, text in texts.items():
            store_file(draft / name, text, False)
        for test, trace in campaign.records():
            names_written[test.number] = _write_test(campaign, test, trace, draft).name
            samples += len(trace)
            tell("writing files", len(names_written) / len(campaign.tests))
    names = {file_name(campaign, t) for t in campaign.tests}
    names |= {f"{name}.toml" for name in names} | {*texts}
    strangers = sum(1 for p in folder.iterdir() if p.name not in names)
    files = tuple(folder / names_written[number] for number in sorted(names_written))
    return CampaignFiles(folder=folder, files=files, samples=samples, strangers=strangers)


def _prepare_folder(folder: Path, overwrite: bool) -> None:
    check_file_name(folder)
    with report_failure(folder, "cannot be written"):
        if folder.exists() and not folder.is_dir():
            raise FileError(folder, "is a file, not a folder")
        if folder.exists() and any(folder.iterdir()) and not overwrite:
            raise FileError(folder, "is not empty; use --overwrite to write into it anyway")


@contextlib.contextmanager
def _make_draft(folder: Path) -> Iterator[Path]:
    """Open a hidden folder whose files are moved to `folder` when the block has ended.

    If the block fails or is interrupted, nothing remains.
    """
    is_new = not folder.exists()
    try:
        with report_failure(folder, "cannot be written"):
            folder.mkdir(parents=True, exist_ok=True)
            with make_hidden_folder(folder) as draft:
                yield draft
                Appearing.begin()
                for path in sorted(draft.iterdir()):
                    sidecar_path(folder / path.name).unlink(missing_ok=True)
                    os.replace(path, folder / path.name)
    except BaseException:
        if is_new:
            shutil.rmtree(folder, ignore_errors=True)
        raise


def _write_test(campaign: Campaign, test: Trial, trace: Trace, folder: Path) -> Path:
    form, fault, cut = select_form(campaign, test), test.practice, None
    path = folder / file_name(campaign, test)
    if fault == "cut_off":
        draw = float(faults.make_rng(campaign.spec.seed, "practice", test.number + 1).random())
        cut = 0.3 + 0.65 * draw
    elif fault == "header_only":
        no_values = np.empty(0)
        trace = evolve(trace, force=no_values, elongation=no_values, time=no_values)
    elif fault == "negative_force":
        trace = evolve(trace, force=-trace.force)
    elif fault == "saturated":
        end = float(np.round(trace.force.max() * SATURATED_AT, 1))
        trace = evolve(trace, force=np.minimum(trace.force, end))
    data = encode_file(trace, form, "kN" if fault == "wrong_unit" else "N", cut)
    return write_with_sidecar(trace, path, data, False, sidecar=fault != "no_sidecar")


def brake_reference(subject: Subject) -> str:
    """Return the brake's name in the catalogue, or its path relative to the campaign's folder."""
    return f"brake-{subject.label}.toml" if subject.file_text else subject.name


def _make_portable(campaign: Campaign) -> Spec:
    """Return the spec with brakes whose paths are valid in the campaign's folder."""
    brakes = tuple(evolve(s.truth, brake=brake_reference(s)) for s in campaign.subjects)
    return evolve(campaign.spec, brakes=brakes)


def format_truth(campaign: Campaign) -> str:
    """Return the true values of each brake and file of a campaign as TOML."""
    lines = [
        f"# SYNTHETIC, layerjam {__version__} virtual laboratory, seed {campaign.spec.seed}.",
        "# True values behind the files in this folder: solve the exercise first, then look.",
        "synthetic = true",
        f"seed = {campaign.spec.seed}",
    ]
    compliance = campaign.spec.machine.compliance
    rows = [("brakes", _true_values(subject, compliance)) for subject in campaign.subjects]
    rows += [
        ("tests", _true_test_values(test, file_name(campaign, test))) for test in campaign.tests
    ]
    for table, values in rows:
        lines += ["", f"[[{table}]]"]
        lines += [f"{key} = {literal(v)}" for key, v in values.items() if v is not None]
    return "\n".join([*lines, ""])


def _true_values(subject: Subject, compliance: float) -> dict[str, Any]:
    """Return the values that fits should find, in SI units: means over the campaign's scatter."""
    true, file_brake, truth = subject.true, subject.known, subject.truth
    stiffness = float(true.stiffness_measured or 0.0)
    series = 1 / (1 / stiffness + compliance)
    exponent = true.pressure_exponent
    return {
        "label": subject.label,
        "brake": brake_reference(subject),
        "scale_factor": true.scale_factor,
        "static": true.film.static,
        "kinetic": true.film.kinetic,
        "ageing": true.film.ageing,
        "static_hold": _format_seconds(true.film.static_hold),
        "friction_product": true.scale_factor * true.film.kinetic,
        # the value that `calibrate` finds with the friction stated in the brake's own file
        "scale_factor_with_known_friction": true.scale_factor
        * true.film.kinetic
        / file_brake.film.kinetic,
        "stiffness": exact_text(stiffness, "N/m"),
        "stiffness_with_machine": f"{series:.9g} N/m",
        "enclosure_factor": truth.enclosure_factor,
        "pressure_exponent": exponent,
        "test_pressure": None if exponent is None else exact_text(true.test_pressure or 0.0, "Pa"),
        "speed_slope": truth.speed_slope,
        "speed_reference": exact_text(truth.speed_reference, "m/s"),
    }


def _true_test_values(test: Trial, file: str) -> dict[str, Any]:
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
        "hold": _format_seconds(test.hold),
        "warmer": f"{test.warmer:.4g} K",
        "practice_fault": test.practice or None,
        "odd": test.odd or None,
        "overshoot": test.overshoot or None,
        "seating": exact_text(test.seating, "m") if test.seating else None,
        "true_speed": exact_text(test.true_speed, "m/s") if pull and test.odd else None,
    }


def _format_seconds(value: float | None) -> str | None:
    return None if value is None else exact_text(value, "s")


def suggest_commands(campaign: Campaign, folder: Path) -> list[str]:
    """Return commands to try on the files, brake by brake."""
    out = []
    for subject in campaign.subjects:
        brake = quote_word(
            str(folder / brake_reference(subject)) if subject.file_text else subject.name
        )
        brake_word = quote_word(str(folder / f"{subject.label}-tested.toml"))
        calibrated_file = quote_word(str(folder / f"{subject.label}-calibrated.toml"))
        tests = [t for t in campaign.tests if t.subject is subject]
        sleds = [t for t in tests if t.kind == "friction"]
        if sleds:
            patterns = _list_file_patterns(campaign, folder, sleds)
            if spec_holds := campaign.spec.friction.holds:
                aged_file = quote_word(str(folder / f"{subject.label}-aged.toml"))
                hold = f"--hold {max(spec_holds):g}s"
                out.append(f"layerjam ageing {patterns} {hold} --brake {brake} --out {aged_file}")
            out.append(f"layerjam friction {patterns} --brake {brake} --out {brake_word}")
            brake = brake_word
        pulls = [t for t in tests if t.kind == "pull"]
        if pulls:
            highest = max(t.vacuum or 0.0 for t in pulls)
            best = [t for t in pulls if t.vacuum == highest]
            others = [t for t in pulls if t.vacuum != highest]
            patterns = _list_file_patterns(campaign, folder, best)
            out.append(f"layerjam calibrate {brake} {patterns} --out {calibrated_file}")
            if others:
                patterns = _list_file_patterns(campaign, folder, others)
                out.append(f"layerjam validate {calibrated_file} {patterns}")
    return out


def _list_file_patterns(campaign: Campaign, folder: Path, tests: Sequence[Trial]) -> str:
    names = {}
    for test in tests:
        # match all repeats and, for pulls, all speeds
        parts = test.name.split("_")[: 3 if test.kind == "pull" else 2]
        names["_".join([*parts, "*"]) + select_form(campaign, test).details.ending] = test
    return " ".join(quote_pattern(folder, name) for name in names)


def format_readme(campaign: Campaign, folder: Path) -> str:
    """Return the README of the folder."""
    tests, spec = campaign.tests, campaign.spec
    sleds = sum(1 for t in tests if t.kind == "friction")
    faulty = sum(1 for t in tests if t.practice)
    lines = [
        "SYNTHETIC. Nothing here was measured.",
        f"Written by the virtual laboratory of layerjam {__version__}, seed {spec.seed}.",
        "",
        f"{count_text(sleds, 'friction test')} and {count_text(len(tests) - sleds, 'pull')}, in "
        f"these layouts: {', '.join(spec.files.layouts)}.",
        "Each file NAME has a NAME.toml with metadata that the file lacks: vacuum, speed,",
        "repeat, brake.",
        "spec.toml is the campaign; layerjam lab spec.toml --out FOLDER recreates it.",
        "truth.toml contains the true values. Solve the exercise first, then look.",
    ]
    if faulty:
        lines += [
            f"{faulty} of the pull files have a fault for you to find. Files that are",
            "rejected are listed; --partial writes the brake from the others.",
        ]
    lines += ["", "To try:", *(f"  {c}" for c in suggest_commands(campaign, folder)), ""]
    return "\n".join(lines)
