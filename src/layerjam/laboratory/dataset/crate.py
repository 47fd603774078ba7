"""Description of a dataset, for repositories (RO-Crate 1.1) and for readers."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any
from urllib.parse import quote

from layerjam._version import __version__
from layerjam.core.errors import count_text
from layerjam.core.verdict import Acceptance
from layerjam.laboratory.dataset import checksums
from layerjam.laboratory.dataset.people import SPDX, Details
from layerjam.laboratory.dataset.recipe import RECIPE, USES, Recipe
from layerjam.laboratory.identify.provenance import sha256

METADATA = "ro-crate-metadata.json"
RAW, BRAKE, LINE, FITTED = "data", "brake.toml", "line.toml", "brake-calibrated.toml"
REPORT, RESULTS, README = "report", "report/results.json", "README.md"
NO_LICENCE = "No licence was stated: all rights remain with the authors."
TYPES = {
    ".csv": "text/csv",
    ".html": "text/html",
    ".json": "application/json",
    ".ljrun": "application/vnd.sqlite3",
    ".md": "text/markdown",
    ".pdf": "application/pdf",
    ".svg": "image/svg+xml",
    ".toml": "application/toml",
    ".txt": "text/plain",
    ".sha256": "text/plain",
    ".xlsx": "application/vnd.openxmlformats-officedocument.spreadsheetml.sheet",
}
CONTEXT = ["https://w3id.org/ro/crate/1.1/context", {"sha256": "https://schema.org/sha256"}]
"""Definition of `sha256`, which RO-Crate 1.1 lacks and schema.org has."""


def format_readme(
    recipe: Recipe, details: Details, brake: str, synthetic: bool, entries: Iterable[Acceptance]
) -> str:
    """Return README.md for readers who do not know the dataset; `brake` is the brake's name."""
    lines = [f"# {details.name}", ""]
    if synthetic:
        lines += ["**Synthetic**: a program wrote these files; nothing was measured.", ""]
    for entry in entries:
        lines += [f"**Accepted**: {entry.notice()}", ""]
    lines += [
        f"Brake: {brake}. {_describe_counts(recipe)}.",
        *dict.fromkeys(f"Not used: `{row.file}`, {row.why}" for row in recipe.unused),
        "",
        f"- `{RAW}/`: the files as the machine wrote them, with their sidecars",
        f"- `{BRAKE}`: the brake before the calibration, `{FITTED}`: after it",
        f"- `{REPORT}/report.html`: the page; `{RESULTS}`: every number",
        f"- `{RECIPE}`: use of each file, and the settings",
        f"- `{checksums.NAME}`: `sha256sum --check {checksums.NAME}` finds changed files",
        "",
        f"To recompute every number, type in a checkout of layerjam {recipe.versions['layerjam']}:",
        "",
        '    pip install ".[publish]"',
        "",
        "and then in this folder:",
        "",
        "    layerjam recompute .",
        "",
        f"Licence: {details.licence or NO_LICENCE}",
        "",
    ]
    return "\n".join(lines)


def _describe_counts(recipe: Recipe) -> str:
    return (
        f"{count_text(len(recipe.used('friction')), 'friction test')}, "
        f"{count_text(len(recipe.used('calibrate')), 'calibration pull')} and "
        f"{count_text(len(recipe.used('validate')), 'validation pull')}"
    )


def make_crate_metadata(
    folder: Path,
    files: Iterable[str],
    recipe: Recipe,
    details: Details,
    brake: str,
    synthetic: bool,
) -> dict[str, Any]:
    """Return ro-crate-metadata.json for files in a folder; `brake` is the brake's name."""
    names = sorted({*files, checksums.NAME} - {METADATA})
    kind = "Synthetic tests" if synthetic else "Tests"
    people = [{"@id": p.id, "@type": "Person", "name": p.name} for p in details.authors]
    root: dict[str, Any] = {
        "@id": "./",
        "@type": "Dataset",
        "name": details.name,
        "description": f"{kind} of the layer-jamming brake {brake}: {_describe_counts(recipe)}, "
        "with all results computed from them.",
        "datePublished": details.date,
        "keywords": "layer jamming, soft robotics, friction, brake",
        "license": NO_LICENCE if details.licence is None else {"@id": SPDX + details.licence},
        "hasPart": _make_references(map(relative_address, names)),
        "mentions": {"@id": "#computed"},
    }
    if people:
        root["author"] = root["creator"] = _make_references(p["@id"] for p in people)
    entry = {"@id": METADATA, "@type": "CreativeWork", "about": {"@id": "./"}}
    graph = [
        entry | {"conformsTo": {"@id": "https://w3id.org/ro/crate/1.1"}},
        root,
        *(_make_file_entry(folder, name) for name in names),
        *people,
        *_make_licence_entry(details),
        *_make_computation_entry(recipe, details, names),
    ]
    return {"@context": CONTEXT, "@graph": graph}


def _make_references(names: Iterable[str]) -> list[dict[str, str]]:
    return [{"@id": name} for name in names]


def relative_address(name: str) -> str:
    """Return the relative address that identifies a file."""
    return quote(name)


def _make_licence_entry(details: Details) -> list[dict[str, str]]:
    name = details.licence
    if name is None:
        return []
    return [{"@id": SPDX + name, "@type": "CreativeWork", "name": name, "identifier": name}]


def _make_file_entry(folder: Path, name: str) -> dict[str, str]:
    """Return the entry of a file; the list of checksums cannot contain its own checksum."""
    path = folder / name
    entry = {
        "@id": relative_address(name),
        "@type": "File",
        "encodingFormat": TYPES.get(path.suffix.lower(), "application/octet-stream"),
    }
    if name == checksums.NAME:
        return entry
    size = str(path.stat().st_size)
    return entry | {"contentSize": size, "sha256": sha256(path)}


def _make_computation_entry(
    recipe: Recipe, details: Details, names: Sequence[str]
) -> list[Mapping[str, Any]]:
    """Return the entries of the computation: its raw files, its results and the programs."""
    version_text = ", ".join(f"{k} {v}" for k, v in recipe.versions.items() if k != "layerjam")
    raw = [recipe.brake, *(name for use in USES for name in recipe.used(use))]
    program = {
        "@id": "#layerjam",
        "@type": "SoftwareApplication",
        "name": "layerjam",
        "version": recipe.versions.get("layerjam", __version__),
        "softwareRequirements": version_text,
        "description": "models soft layer-jamming brakes; `layerjam recompute` checks this dataset",
    }
    results = [relative_address(n) for n in names if n == FITTED or n.startswith(f"{REPORT}/")]
    action = {
        "@id": "#computed",
        "@type": "CreateAction",
        "name": "friction, calibration and validation from the raw files",
        "endTime": details.date,
        "instrument": {"@id": program["@id"]},
        "object": _make_references(map(relative_address, raw)),
        "result": _make_references(results),
    }
    return [program, action]
