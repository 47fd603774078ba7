"""A published dataset is doctored in every kind of file, and sealed again: `recompute` names it.

The attacker knows the form: every checksum and every digest of the description is written anew.
"""

from __future__ import annotations

import ctypes
import hashlib
import json
import re
import shutil
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pypdfium2
import pytest
from pypdfium2 import raw as pdfium

from campaigns import bench as virtual
from layerjam.commands import recomputing
from layerjam.commands.publish import Published, publish, recompute
from layerjam.device.load import load
from layerjam.errors import FileError
from layerjam.measure.sidecar import Facts, write_facts
from links import require_link
from report.brake_files import BRAKE, campaign

pytestmark = pytest.mark.slow
SUMS, CRATE = "checksums.sha256", "ro-crate-metadata.json"
HTML, PDF, RESULTS = "report/report.html", "report/report.pdf", "report/results.json"
NUMBERS, FITTED = "report/numbers.csv", "brake-calibrated.toml"
Doctor = Callable[[Path], None]


@pytest.fixture(scope="module")
def published(tmp_path_factory: pytest.TempPathFactory) -> Published:
    folder = tmp_path_factory.mktemp("tests")
    made = campaign(folder)
    for path in made.friction:
        write_facts(path, Facts(normal_force=2.45, brake=BRAKE, synthetic=True), overwrite=True)
    for path in made.validate[2:]:
        path.unlink()
        path.with_name(path.name + ".toml").unlink()
    (folder / "notes.txt").write_text("the third pull was done after lunch\n")
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


@pytest.fixture(scope="module", autouse=True)
def derived_once(tmp_path_factory: pytest.TempPathFactory) -> Any:
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
        for name, path in names.items():
            new = {"@id": name, "@type": "File", "encodingFormat": "text/plain"}
            entry = graph.setdefault(name, new)
            entry |= {"contentSize": str(path.stat().st_size), "sha256": digest(path)}
        gone = {i for i, e in graph.items() if e["@type"] == "File"} - {*names, SUMS}
        for name in gone:
            del graph[name]
        graph["./"]["hasPart"] = [{"@id": name} for name in sorted({*names, SUMS})]
        (root / CRATE).write_text(json.dumps({**crate, "@graph": [*graph.values()]}, indent=2))
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
    without_pull(held)
    held["unused"]["data/pull-3.csv"] = {"use": "calibrate", "why": "the file is incomplete"}


CELL = swap(HTML, r">0\.2\d\d\d<", ">0.2177<")


def older_form(root: Path) -> None:
    """The recipe of an earlier form, and a number of the page."""
    values("recipe.json", lambda held: held.update(format=1))(root)
    CELL(root)


def other_versions(root: Path) -> None:
    """Programs of other versions, and a number of the page."""
    values("recipe.json", lambda held: held["versions"].update(layerjam="0.0.9", numpy="1.0"))(root)
    CELL(root)


SEALED: dict[str, tuple[str, Doctor]] = {
    "page: a number": (HTML, CELL),
    "page: a check": (HTML, swap(HTML, r"LOOK|ok</", "fine</")),
    "page: the banner": (HTML, swap(HTML, "Synthetic data: [^<]*", "Measured data.")),
    "page: a sentence more": (HTML, swap(HTML, "</body>", "<p>Better than all.</p>\n</body>")),
    "page: hidden by a style": (HTML, swap(HTML, "</style>", "table{display:none}</style>")),
    "page: a curve": (HTML, lambda root: first_curve(root, HTML)),
    "page: a colour": (HTML, swap(HTML, r"stroke: (var\(--\w+\)|#\w{6})", "stroke: #fffffe")),
    "page: deleted": (HTML, gone(HTML)),
    "page: empty": (HTML, content(HTML, b"")),
    "pdf: a number typed over": (PDF, pdf(typed_over)),
    "pdf: painted over": (PDF, pdf(painted_over)),
    "pdf: a page removed": (PDF, pdf(lambda document: document.del_page(0))),
    "pdf: another file": (PDF, content(PDF, b"%PDF-1.7 nothing")),
    "pdf: deleted": (PDF, gone(PDF)),
    "figure: a curve": (
        "report/figures/validation.svg",
        lambda root: first_curve(root, "report/figures/validation.svg"),
    ),
    "figure: a label": (
        "report/figures/calibration.svg",
        swap("report/figures/calibration.svg", r"#DejaVuSans-3\d", "#DejaVuSans-40"),
    ),
    "figure: deleted": ("report/figures/residuals.svg", gone("report/figures/residuals.svg")),
    "figure: one more": ("report/figures/best.svg", content("report/figures/best.svg", b"<svg/>")),
    "results: the headline": (RESULTS, polished("validation.mape", 0.5)),
    "results: one millionth and more": (RESULTS, polished("calibration.stiffness", 1 + 2e-6)),
    "results: a number of a table": (RESULTS, polished("numbers.3.value", 1.01)),
    "results: a verdict": (RESULTS, swap(RESULTS, '"level": "passed"', '"level": "note"')),
    "results: a sentence": (RESULTS, values(RESULTS, lambda h: h.update(window="best part"))),
    "results: not synthetic": (RESULTS, values(RESULTS, lambda h: h.update(synthetic=False))),
    "results: a key more": (RESULTS, values(RESULTS, lambda h: h.update(award=1))),
    "results: a warning less": (RESULTS, values(RESULTS, lambda h: h.update(warnings={}))),
    "results: broken": (RESULTS, content(RESULTS, b"{")),
    "results: deleted": (RESULTS, gone(RESULTS)),
    "numbers: a value": (NUMBERS, swap(NUMBERS, r",0\.2(\d)", r",0.3\1")),
    "numbers: a name": (NUMBERS, swap(NUMBERS, "friction: static", "friction: kinetic")),
    "numbers: a unit": (NUMBERS, swap(NUMBERS, ",N/m,", ",kN/m,")),
    "numbers: a row less": (NUMBERS, swap(NUMBERS, r'\n"validation[^\n]*', "")),
    "numbers: empty": (NUMBERS, content(NUMBERS, b"")),
    "fitted brake: a number": (FITTED, swap(FITTED, r"value = 0\.\d", "value = 0.1")),
    "fitted brake: a source": (FITTED, swap(FITTED, "synthetic = true", "synthetic = false")),
    "fitted brake: the date": (FITTED, swap(FITTED, r'date = "20', 'date = "19')),
    "fitted brake: deleted": (FITTED, gone(FITTED)),
    "brake: a size": (RESULTS, swap("brake.toml", 'value = "13 mm"', 'value = "31 mm"')),
    "data: all forces": (RESULTS, scaled_pull),
    "data: a deleted pull": (RESULTS, gone("data/pull-3.csv")),
    "data: another pull in its place": (
        RESULTS,
        lambda root: shutil.copy(root / "data/pull-1.csv", root / "data/pull-2.csv"),
    ),
    "data: the vacuum in a sidecar": (
        RESULTS,
        swap("data/pull-1.csv.toml", r'vacuum = "94', 'vacuum = "84'),
    ),
    "data: no sidecar": (RESULTS, gone("data/pull-1.csv.toml")),
    "data: a measurement more": (
        "recipe.json",
        lambda root: virtual.write_bluehill(
            virtual.pull(load(BRAKE).brake, 94.5e3, 0.013, 0.04), root / "data" / "new.csv"
        ),
    ),
    "recipe: a pull left out": ("recipe.json", values("recipe.json", without_pull)),
    "recipe: a pull refused": ("recipe.json", values("recipe.json", with_reason)),
    "recipe: an option": (
        RESULTS,
        values("recipe.json", lambda held: held["options"].update({"start": 0.05, "end": 0.06})),
    ),
    "recipe: the title": (
        CRATE,
        values("recipe.json", lambda held: held["stated"].update(name="Better tests")),
    ),
    "recipe: the date": (
        HTML,
        values("recipe.json", lambda held: held["stated"].update(date="2020-01-01")),
    ),
    "recipe: an older form": (HTML, older_form),
    "recipe: other versions": (HTML, other_versions),
    "readme: the counts": ("README.md", swap("README.md", "3 friction tests", "30 friction tests")),
    "readme: the licence": ("README.md", swap("README.md", "CC-BY-4.0", "CC0-1.0")),
    "description: the author": (CRATE, swap(CRATE, "Ada Lovelace", "Charles Babbage")),
    "description: the licence": (CRATE, swap(CRATE, "CC-BY-4.0", "CC0-1.0")),
    "description: the counts": (CRATE, swap(CRATE, "3 friction tests", "30 friction tests")),
    "description: what was computed from what": (
        CRATE,
        values(
            CRATE, lambda held: next(e for e in held["@graph"] if "object" in e)["object"].pop()
        ),
    ),
    "description: deleted": (CRATE, gone(CRATE)),
}
"""{what is doctored: (file that must be named, how)}; checksums and description agree with it."""


NOWHERE = f"{'0' * 64}  data/x.csv"
UNSEALED: dict[str, tuple[str, Doctor]] = {
    "vacuum line: a size": ("line.toml", swap("line.toml", r"\d", "9")),
    "notes: a word": ("data/notes.txt", swap("data/notes.txt", "lunch", "midnight")),
    "description: a digest": (CRATE, swap(CRATE, r'"sha256": "[0-9a-f]{4}', '"sha256": "0000')),
    "checksums: a line less": (HTML, listed(lambda lines: [n for n in lines if HTML not in n])),
    "checksums: not the description": (
        CRATE,
        listed(lambda lines: [n for n in lines if CRATE not in n]),
    ),
    "checksums: an empty line": (SUMS, listed(lambda lines: [lines[0], "", *lines[1:]])),
    "checksums: a line more": (
        "data/x.csv",
        listed(lambda lines: [*lines, NOWHERE]),
    ),
    "checksums: a line twice": (SUMS, listed(lambda lines: [*lines, lines[0]])),
    "checksums: no digest": (SUMS, listed(lambda lines: [*lines[1:], lines[0][2:]])),
    "checksums: deleted": (SUMS, gone(SUMS)),
    "checksums: empty": (SUMS, content(SUMS, b"")),
    "a file more": ("report/final.pdf", content("report/final.pdf", b"%PDF")),
    "a measurement outside": ("data/pull-3.csv", linked_outside),
    "a link more": (
        "more.csv",
        lambda root: require_link(root / "more.csv", "data/pull-1.csv"),
    ),
}
"""The same; the attacker changes this alone."""


def named(found: Any) -> set[str]:
    files = {one["file"] for one in found.differs}
    return {*files, *found.changed_files, *found.added_files}


def attacked(published: Published, tmp_path: Path, doctor: Doctor) -> Path:
    copy = tmp_path / "copy"
    shutil.copytree(published.folder, copy)
    doctor(copy)
    return copy


def test_an_honest_dataset_is_equal_sealed_or_not(published: Published, tmp_path: Path) -> None:
    copy = attacked(published, tmp_path, seal)
    for folder in (published.folder, copy):
        found = recompute(folder)
        assert found.equal and found.exit_code == 0 and not named(found), str(found)
        assert not found.not_compared
    assert recompute(published.folder).fingerprint == digest(Path(published.folder) / SUMS)


@pytest.mark.parametrize("name", SEALED)
def test_a_sealed_forgery_is_found(published: Published, tmp_path: Path, name: str) -> None:
    file, doctor = SEALED[name]
    copy = attacked(published, tmp_path, doctor)
    seal(copy)
    found = recompute(copy)
    assert not found.equal and found.exit_code == 1
    assert file in named(found), str(found)
    assert file in str(found)
    assert found.fingerprint != recompute(published.folder).fingerprint


@pytest.mark.parametrize("name", UNSEALED)
def test_a_single_changed_file_is_named(published: Published, tmp_path: Path, name: str) -> None:
    file, doctor = UNSEALED[name]
    found = recompute(attacked(published, tmp_path, doctor))
    assert not found.equal and found.exit_code == 1
    assert file in named(found), str(found)
    assert file in str(found)


def test_a_file_in_a_zip_twice_is_refused(published: Published, tmp_path: Path) -> None:
    packed = Path(shutil.make_archive(str(tmp_path / "sent"), "zip", published.folder))
    assert recompute(packed).equal
    with pytest.warns(UserWarning, match="Duplicate"), zipfile.ZipFile(packed, "a") as archive:
        archive.writestr(HTML, "<p>other</p>")
    with pytest.raises(FileError, match="twice"):
        recompute(packed)
