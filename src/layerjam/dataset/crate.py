"""The description of a dataset that repositories read: RO-Crate 1.1."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from layerjam._version import __version__
from layerjam.dataset.people import SPDX, Author
from layerjam.errors import MissingExtraError

if TYPE_CHECKING:
    from rocrate.rocrate import ROCrate

METADATA = "ro-crate-metadata.json"
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
SOFTWARE = "#layerjam"


@dataclass(frozen=True, kw_only=True)
class About:
    """What a dataset says of itself.

    `date` (ISO) of publication, `made_from` its raw files, `numbers` what was computed of them.
    """

    name: str
    description: str
    date: str
    licence: str | None
    authors: Sequence[Author]
    versions: Mapping[str, str]
    made_from: Sequence[str]
    numbers: Sequence[str]


def require() -> None:
    """Raise MissingExtraError where the library is not installed."""
    with MissingExtraError.without("a published dataset (rocrate)", "publish"):
        import rocrate.rocrate  # noqa: F401


def write_metadata(folder: Path, digests: Mapping[str, str], about: About) -> None:
    """Write ro-crate-metadata.json for the files {path: SHA-256} of a folder."""
    from rocrate.model.contextentity import ContextEntity
    from rocrate.rocrate import ROCrate

    crate = ROCrate(version="1.1")
    crate.name, crate.description = about.name, about.description
    crate.datePublished = about.date
    crate.license = _licence(crate, about.licence)
    crate.root_dataset["keywords"] = "layer jamming, soft robotics, friction, brake"
    people = [
        crate.add(ContextEntity(crate, one.id, {"@type": "Person", "name": one.name}))
        for one in about.authors
    ]
    if people:
        one_or_all = people[0] if len(people) == 1 else people
        crate.root_dataset["author"] = crate.root_dataset["creator"] = one_or_all
    for name, digest in digests.items():
        crate.add_file(folder / name, name, properties=_described(folder / name, digest))
    _made(crate, about)
    # RO-Crate 1.1's own words end before schema.org took this one
    crate.metadata.extra_terms["sha256"] = "https://schema.org/sha256"
    crate.metadata.write(folder)


def _licence(crate: ROCrate, licence: str | None) -> Any:
    from rocrate.model.contextentity import ContextEntity

    if licence is None:
        return NO_LICENCE
    about = {"@type": "CreativeWork", "name": licence, "identifier": licence}
    return crate.add(ContextEntity(crate, SPDX + licence, about))


def _described(path: Path, digest: str) -> dict[str, Any]:
    return {
        "contentSize": str(path.stat().st_size),
        "encodingFormat": TYPES.get(path.suffix.lower(), "application/octet-stream"),
        "sha256": digest,
    }


def _made(crate: ROCrate, about: About) -> None:
    """What was computed from what, and with which programs."""
    from rocrate.model.contextentity import ContextEntity

    others = ", ".join(f"{k} {v}" for k, v in about.versions.items() if k != "layerjam")
    program = {
        "@type": "SoftwareApplication",
        "name": "layerjam",
        "version": __version__,
        "softwareRequirements": others,
        "description": "computes soft layer-jamming brakes; `layerjam recompute` checks this",
    }
    software = crate.add(ContextEntity(crate, SOFTWARE, program))
    action = {
        "@type": "CreateAction",
        "name": "friction, calibration and validation from the raw files",
        "endTime": about.date,
        "instrument": software,
        "object": [crate.dereference(name) for name in about.made_from],
        "result": [crate.dereference(name) for name in about.numbers],
    }
    made = crate.add(ContextEntity(crate, "#computed", action))
    crate.root_dataset["mentions"] = made
