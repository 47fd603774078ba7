"""The laboratory's files, readable or rejected, as the page shows them; practice files."""

import shutil
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from types import MappingProxyType

from layerjam.core.command.declare import Progress
from layerjam.core.errors import FileError, FitError, MissingExtraError, QuantityError
from layerjam.core.units import show
from layerjam.laboratory.identify.provenance import rename_files
from layerjam.laboratory.measure.sidecar import SIDECAR_ENDING, Facts, read_facts
from layerjam.laboratory.measure.trace import Trace
from layerjam.workbench.call import Call, Options, Subject
from layerjam.workbench.proposals import find_read_error
from layerjam.workbench.said import ROLES, Edits, sidecar_text
from layerjam.workbench.spoken import page_text
from layerjam.workbench.uploads import Upload, Uploads
from layerjam.workbench.widgets import one_line

CURVE = 400
"""Number of samples per curve that are kept for drawing."""
TONES = MappingProxyType({"understood": "#00684c", "refused": "#a63d00", "left out": "#5b6672"})
"""{state: dark background colour}; files that need a choice have a different colour."""


@dataclass(frozen=True, eq=False)
class Row:
    """A file as the page shows it: readable, or rejected with a reason."""

    upload: Upload
    role: str
    facts: Facts = field(default_factory=Facts)
    understood: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    refused: str = ""
    traces: tuple[Trace, ...] = ()

    @property
    def missing_entry(self) -> str:
        """Metadata entry that the file's use requires but lacks; empty if none is missing."""
        if self.role in ("calibrate", "validate") and not self.refused:
            vacuums = [t.facts.vacuum for t in self.traces]
            return "vacuum?" if not vacuums or None in vacuums else ""
        if self.role == "friction" and not self.facts.normal_force:
            return "normal force?"
        return ""

    @property
    def is_usable(self) -> bool:
        """Whether a step can use the file."""
        return not self.refused and not self.missing_entry and self.role != "aside"

    @property
    def vacuum(self) -> float | None:
        """Vacuum stated in the file's sidecar or header [Pa]."""
        return self.traces[0].facts.vacuum if self.traces else self.facts.vacuum

    @property
    def is_synthetic(self) -> bool:
        """Whether a program generated the file."""
        return any(t.facts.synthetic for t in self.traces) or self.facts.synthetic

    def table_cells(self) -> dict[str, str]:
        """Return the file's cells in the table."""
        state = "left out" if self.role == "aside" else "understood"
        state = "refused" if self.refused else self.missing_entry or state
        vacuum, force = self.vacuum, self.facts.normal_force
        return {
            "id": self.upload.key,
            "name": self.upload.shown,
            "role": ROLES[self.role],
            "vacuum": "–" if vacuum is None else show(vacuum, "Pa"),
            "force": "–" if force is None else show(force, "N"),
            "state": state,
            "tone": TONES.get(state, "#8a4b00"),
            "refused": self.refused if len(self.refused) < 200 else self.refused[:199] + "…",
        }


def read_rows(
    uploads: Uploads, edits: Edits, standard: str, read: Callable[..., Row], progress: Progress
) -> list[Row]:
    """Write the sidecar of each file, and return its row from `read`, which may use a cache."""
    files, rows = uploads.files_in_use, []
    for count, upload in enumerate(files):
        edit = edits.get(upload.key, {})
        text = sidecar_text(uploads.sidecars.get(upload.shown, ""), edit)
        progress(f"reading {upload.shown}", count / len(files))
        rows.append(read(uploads.write_sidecar(upload, text), edit.get("role", ""), standard))
    return rows


OF_A_FILE = (FileError, FitError, QuantityError, MissingExtraError)
"""Errors that a file can cause when it is read; others have a different cause."""


def read_row(upload: Upload, role: str, standard: str) -> Row:
    """Read a file and its sidecar as its `role` requires; if that is empty, choose a role."""
    row = Row(upload, role if role in ROLES else "calibrate")
    try:
        facts = read_facts(upload.path)
    except FileError as err:
        return replace(row, refused=_use_shown_name(one_line(err), upload))
    if role not in ROLES:
        role = "friction" if facts.normal_force else "calibrate"
    row = replace(row, role=role, facts=facts)
    is_friction = role == "friction"
    inputs: Options = {"standard": standard} if is_friction else {}
    if is_friction and standard == "paper" and not facts.normal_force:
        # the normal force only scales the friction, so any value gives traces of the same shape;
        # the page asks for the true one
        inputs["normal_force"] = "1 N"
    call = Call("friction" if is_friction else "pull", options=inputs, files=(upload,))
    try:
        result = call.run()
    except OF_A_FILE as err:
        reason = find_read_error(upload.path) or one_line(err).removeprefix(f"{upload.shown}: ")
        return replace(row, refused=_use_shown_name(reason, upload))
    traces = result.record[0] if is_friction else [t for t, _ in result.record]
    if is_friction and standard != "paper" and not facts.normal_force:
        facts = replace(facts, normal_force=result.record[1].normal_force)
    readings = dict.fromkeys(s for sentences in result.understood.values() for s in sentences)
    problem = page_text("; ".join(f"{path}: {reason}" for path, reason in result.refused.items()))
    if not traces:
        problem = _use_shown_name(find_read_error(upload.path) or problem, upload)
    return replace(
        row,
        facts=facts,
        understood=tuple(readings),
        warnings=tuple(_use_shown_name(w, upload) for t in traces for w in t.warnings),
        refused="" if traces else problem,
        traces=tuple(t.thinned(CURVE) for t in traces),
    )


def _use_shown_name(text: object, upload: Upload) -> str:
    return str(rename_files(str(text), {upload.path.name: upload.shown}))


def make_practice_files(folder: Path, progress: Callable[[str, float], None]) -> dict[str, bytes]:
    """Return {name: content} of the practice campaign's files and their sidecars."""
    place = folder / "practice"
    shutil.rmtree(place, ignore_errors=True)
    try:
        campaign = Call("lab", (Subject("practice"),)).run(out=place, progress=progress)
        contents = {}
        for path in map(Path, campaign.files):
            for file in (path, path.with_name(path.name + SIDECAR_ENDING)):
                if file.exists():
                    contents[file.name] = file.read_bytes()
        return contents
    finally:
        shutil.rmtree(place, ignore_errors=True)
