"""A forger of datasets, who knows the form: changes in every kind of file, and new checksums."""

from __future__ import annotations

import contextlib
import ctypes
import hashlib
import json
import re
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any
from urllib.parse import quote

import pypdfium2
import pytest
from pypdfium2 import raw as pdfium

from laboratory.figures.brake_files import BRAKE, campaign
from layerjam.laboratory.commands import recomputing
from layerjam.laboratory.commands.publish import Published, publish
from layerjam.laboratory.measure.sidecar import Facts, write_facts
from links import require_link

SUMS, CRATE = "checksums.sha256", "ro-crate-metadata.json"
HTML, PDF, RESULTS = "report/report.html", "report/report.pdf", "report/results.json"
NUMBERS, FITTED = "report/numbers.csv", "brake-calibrated.toml"
Doctor = Callable[[Path], Any]


def publish_honestly(tmp_path_factory: pytest.TempPathFactory) -> Published:
    """A small campaign as a dataset, as its authors publish it."""
    folder = tmp_path_factory.mktemp("tests")
    made = campaign(folder)
    for path in made.friction:
        write_facts(path, Facts(normal_force=2.45, brake=BRAKE, synthetic=True), overwrite=True)
    for path in made.validate[2:]:
        path.unlink()
        path.with_name(path.name + ".toml").unlink()
    (folder / "notes.txt").write_text("the third pull was done after lunch\n")
    (folder / "Prüfstand.txt").write_text("the rig in the cellar\n")
    return publish(
        folder,
        out=tmp_path_factory.mktemp("out") / "dataset",
        brake=BRAKE,
        line="choi2018",
        pulls=made.pulls,
        friction=made.friction,
        validate=made.validate[:2],
        title="Honest tests",
        licence="CC-BY-4.0",
        author=["Ada Lovelace,0000-0002-1825-0097"],
    )


@contextlib.contextmanager
def derive_once(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """What follows from inputs is computed once for the same inputs."""
    derive, known = recomputing.derive_results, {}

    def remembered(root: Path, recipe: Any, out: Path, tell: Any) -> Any:
        inputs = sorted(p for p in root.rglob("*") if p.is_file() and "report" not in p.parts)
        key = hashlib.sha256(repr(recipe).encode())
        for path in inputs:
            if path.name not in (SUMS, CRATE, FITTED, "README.md"):
                key.update(path.relative_to(root).as_posix().encode() + path.read_bytes())
        if key.hexdigest() not in known:
            kept = tmp_path_factory.mktemp("derived") / "again"
            kept.mkdir()
            known[key.hexdigest()] = (kept, derive(root, recipe, kept, tell))
        kept, answer = known[key.hexdigest()]
        shutil.copytree(kept, out, dirs_exist_ok=True)
        return answer

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(recomputing, "derive_results", remembered)
        yield


def digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def seal(root: Path) -> None:
    """Write description and checksums so that both agree with the files."""
    files = sorted(p for p in root.rglob("*") if p.is_file() and p.name not in (SUMS, CRATE))
    names = {p.relative_to(root).as_posix(): p for p in files}
    if (root / CRATE).is_file():
        crate = json.loads((root / CRATE).read_text())
        graph = {entry["@id"]: entry for entry in crate["@graph"]}
        of = {quote(name): path for name, path in names.items()}
        for name, path in of.items():
            new = {"@id": name, "@type": "File", "encodingFormat": "text/plain"}
            entry = graph.setdefault(name, new)
            entry |= {"contentSize": str(path.stat().st_size), "sha256": digest(path)}
        gone = {i for i, e in graph.items() if e["@type"] == "File"} - {*of, SUMS}
        for name in gone:
            del graph[name]
        parts = sorted([*names, SUMS])
        graph["./"]["hasPart"] = [{"@id": quote(name)} for name in parts]
        text = json.dumps({**crate, "@graph": [*graph.values()]}, indent=2, ensure_ascii=False)
        if json.loads((root / CRATE).read_text()) != json.loads(text):
            (root / CRATE).write_text(text + "\n")
        names[CRATE] = root / CRATE
    lines = [f"{digest(path)}  {name}\n" for name, path in sorted(names.items())]
    (root / SUMS).write_text("".join(lines))


def swap(name: str, pattern: str, new: str) -> Doctor:
    """Replace the first match in a text; the pattern must be there."""

    def doctor(root: Path) -> None:
        text = (root / name).read_text()
        changed, count = re.subn(pattern, new, text, count=1)
        assert count == 1 and changed != text, f"{pattern} is not in {name}"
        (root / name).write_text(changed)

    return doctor


def values(name: str, change: Callable[[Any], None]) -> Doctor:
    """Change a JSON document."""

    def doctor(root: Path) -> None:
        held = json.loads((root / name).read_text())
        before = json.dumps(held)
        change(held)
        assert json.dumps(held) != before
        (root / name).write_text(json.dumps(held, indent=2))

    return doctor


def gone(name: str) -> Doctor:
    return lambda root: (root / name).unlink()


def content(name: str, data: bytes) -> Doctor:
    def doctor(root: Path) -> None:
        (root / name).parent.mkdir(exist_ok=True)
        (root / name).write_bytes(data)

    return doctor


def pdf(change: Callable[[Any], None]) -> Doctor:
    """Change a PDF as an editor of PDFs does."""

    def doctor(root: Path) -> None:
        with pypdfium2.PdfDocument((root / PDF).read_bytes()) as document:
            change(document)
            document.save(str(root / PDF))

    return doctor


def typed_over(document: Any) -> None:
    """A new number on the first page."""
    page = document[0]
    text = pdfium.FPDFPageObj_NewTextObj(document, b"Helvetica", 12.0)
    words = [*map(ord, "MAPE 0.4 %"), 0]
    pdfium.FPDFText_SetText(text, (ctypes.c_ushort * len(words))(*words))
    pdfium.FPDFPage_InsertObject(page, text)
    page.gen_content()


def painted_over(document: Any) -> None:
    """A white patch on a figure; no word changes."""
    page = document[len(document) - 2]
    patch = pdfium.FPDFPageObj_CreateNewRect(100.0, 300.0, 200.0, 200.0)
    pdfium.FPDFPageObj_SetFillColor(patch, 255, 255, 255, 255)
    pdfium.FPDFPath_SetDrawMode(patch, pdfium.FPDF_FILLMODE_ALTERNATE, False)
    pdfium.FPDFPage_InsertObject(page, patch)
    page.gen_content()


def attached(document: Any) -> None:
    """A file in the PDF; no page changes."""
    document.new_attachment("other numbers.txt").set_data(b"MAPE 0.4 %")


def in_bytes(name: str, old: bytes, new: bytes) -> Doctor:
    def doctor(root: Path) -> None:
        data = (root / name).read_bytes()
        assert old in data and new not in data
        (root / name).write_bytes(data.replace(old, new, 1))

    return doctor


def added(name: str, data: bytes) -> Doctor:
    return lambda root: (root / name).write_bytes((root / name).read_bytes() + data)


def drawn(name: str, pattern: str, factor: float) -> Doctor:
    """The first number in a drawing after a pattern, times a factor."""

    def doctor(root: Path) -> None:
        text = (root / name).read_text()
        found = re.search(rf"{pattern}(\d*\.\d+)", text)
        assert found is not None, pattern
        new = f"{float(found[1]) * factor:.6f}"
        (root / name).write_text(text[: found.start(1)] + new + text[found.end(1) :])

    return doctor


def first_curve(root: Path, name: str) -> None:
    """Move the middle of the longest curve by a point."""
    text = (root / name).read_text()
    paths = re.findall(r' d="M [^"]*"', text)
    longest = max(paths, key=len)
    numbers = re.findall(r"-?\d+\.\d+", longest)
    middle = numbers[len(numbers) // 2]
    moved = longest.replace(middle, f"{float(middle) + 1:.6f}", 1)
    (root / name).write_text(text.replace(longest, moved, 1))


def scaled_pull(root: Path) -> None:
    """All forces of a pull 2 % greater."""
    path = root / "data" / "pull-2.csv"
    lines = path.read_text().splitlines()
    done = []
    for line in lines:
        head, comma, last = line.rpartition(",")
        bare = last.strip('"')
        number = re.fullmatch(r"-?\d+\.\d+", bare)
        done.append(f'{head}{comma}"{1.02 * float(bare):.5f}"' if number and comma else line)
    assert done != lines
    path.write_text("\n".join(done) + "\n")


def polished(path: str, factor: float) -> Doctor:
    """A number of results.json times a factor."""

    def change(held: Any) -> None:
        *way, last = path.split(".")
        for key in way:
            held = held[int(key) if isinstance(held, list) else key]
        held[int(last) if isinstance(held, list) else last] *= factor

    return values(RESULTS, change)


def listed(change: Callable[[list[str]], list[str]]) -> Doctor:
    """Change the lines of the checksums."""

    def doctor(root: Path) -> None:
        lines = (root / SUMS).read_text().splitlines()
        assert change(lines) != lines
        (root / SUMS).write_text("".join(f"{line}\n" for line in change(lines)))

    return doctor


def linked_outside(root: Path) -> None:
    """A measurement that is a link to a file elsewhere, of the same content today."""
    path = root / "data" / "pull-3.csv"
    outside = root.parent / "elsewhere.csv"
    shutil.move(path, outside)
    require_link(path, outside)


def without_pull(held: Any) -> None:
    held["calibrate"].remove("data/pull-3.csv")


def with_reason(held: Any) -> None:
    why = "the file is incomplete"
    held["unused"].append({"file": "data/pull-3.csv", "use": "calibrate", "why": why})


CELL = swap(HTML, r">0\.2\d\d\d<", ">0.2177<")


def older(form: int) -> Doctor:
    """The recipe of an earlier form, as a careful forger writes it."""

    def change(held: Any) -> None:
        held["unused"] = {row["file"]: row for row in held["unused"]}
        held["format"] = form
        if form == 1:
            del held["stated"]

    return values("recipe.json", change)


def older_form(root: Path) -> None:
    """The recipe of an earlier form, and a number of the page."""
    older(1)(root)
    CELL(root)


def other_versions(root: Path) -> None:
    """Programs of other versions, and a number of the page."""
    values("recipe.json", lambda held: held["versions"].update(layerjam="0.0.9", numpy="1.0"))(root)
    CELL(root)


def named(found: Any) -> set[str]:
    files = {one["file"] for one in found.differs}
    return {*files, *found.changed_files, *found.added_files}


def attacked(published: Published, tmp_path: Path, doctor: Doctor) -> Path:
    copy = tmp_path / "copy"
    shutil.copytree(published.folder, copy)
    doctor(copy)
    return copy
