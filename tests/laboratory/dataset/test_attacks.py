"""A published dataset is doctored in every kind of file, and sealed again: `recompute` names it."""

from __future__ import annotations

import shutil
import zipfile
from pathlib import Path

import pytest

from laboratory.campaigns import bench as virtual
from laboratory.dataset.forger import (
    CELL,
    CRATE,
    FITTED,
    HTML,
    NUMBERS,
    PDF,
    RESULTS,
    SUMS,
    Doctor,
    added,
    attached,
    attacked,
    content,
    digest,
    drawn,
    first_curve,
    gone,
    in_bytes,
    linked_outside,
    listed,
    named,
    older_form,
    other_versions,
    painted_over,
    pdf,
    polished,
    scaled_pull,
    seal,
    swap,
    typed_over,
    values,
    with_reason,
    without_pull,
)
from laboratory.figures.brake_files import BRAKE
from layerjam.brake.device.load import load
from layerjam.core.errors import FileError
from layerjam.laboratory.commands.publish import Published, recompute
from links import require_link

pytestmark = [pytest.mark.slow, pytest.mark.usefixtures("derived_once")]


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
    "pdf: an attachment": (PDF, pdf(attached)),
    "pdf: bytes after its end": (PDF, added(PDF, b"\nMAPE 0.4 %\n")),
    "pdf: its title": (PDF, in_bytes(PDF, b"/Title(Test report", b"/Title(Best report")),
    "pdf: its author": (PDF, in_bytes(PDF, b"/Author(layerjam)", b"/Author(manybrag)")),
    "pdf: deleted": (PDF, gone(PDF)),
    "figure: a curve": (
        "report/figures/validation.svg",
        lambda root: first_curve(root, "report/figures/validation.svg"),
    ),
    "figure: a label": (
        "report/figures/calibration.svg",
        swap("report/figures/calibration.svg", r"#DejaVuSans-3\d", "#DejaVuSans-40"),
    ),
    "figure: a stroke": (
        "report/figures/validation.svg",
        drawn("report/figures/validation.svg", "stroke-width: ", 1.01),
    ),
    "figure: a scale": (
        "report/figures/validation.svg",
        drawn("report/figures/validation.svg", r"scale\(", 1.05),
    ),
    "page: a stroke": (HTML, drawn(HTML, "stroke-width: ", 1.01)),
    "figure: deleted": ("report/figures/residuals.svg", gone("report/figures/residuals.svg")),
    "figure: one more": ("report/figures/best.svg", content("report/figures/best.svg", b"<svg/>")),
    "results: the headline": (RESULTS, polished("validation.mape", 0.5)),
    "results: one millionth and more": (RESULTS, polished("calibration.stiffness", 1 + 2e-6)),
    "results: a number of a table": (RESULTS, polished("numbers.3.value", 1.01)),
    "results: a verdict": (RESULTS, swap(RESULTS, '"level": "passed"', '"level": "note"')),
    "results: a sentence": (RESULTS, values(RESULTS, lambda h: h.update(window="best part"))),
    "results: not synthetic": (RESULTS, values(RESULTS, lambda h: h.update(synthetic=False))),
    "results: a key more": (RESULTS, values(RESULTS, lambda h: h.update(award=1))),
    "results: a key twice": (RESULTS, swap(RESULTS, '"date"', '"date": "2020-01-01", "date"')),
    "results: other spaces": (RESULTS, swap(RESULTS, '"date": ', '"date":  ')),
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
    "fitted brake: a comment": (FITTED, added(FITTED, b"# checked by a notary\n")),
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
    "recipe: a key twice": (
        "recipe.json",
        swap("recipe.json", '"licence"', '"licence": "CC0-1.0", "licence"'),
    ),
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
    "description: other spaces": (CRATE, swap(CRATE, '"@graph": ', '"@graph":  ')),
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
    assert found.fingerprint != digest(Path(published.folder) / SUMS)


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
