"""The report of one brake: self-contained, printed as well, every number also in the CSV."""

from __future__ import annotations

import csv
import json
import re
import sys
from html.parser import HTMLParser
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from scipy import stats

from laboratory.figures.brake_files import BRAKE, NORMAL_FORCE, Campaign, campaign, draw_nothing
from layerjam.core.command.results import Result
from layerjam.core.errors import FileError
from layerjam.laboratory.commands.report import report
from layerjam.laboratory.figures import brake_files as writer
from layerjam.laboratory.figures.brake_numbers import COLUMNS, Number

FILES = {"report.html", "report.pdf", "numbers.csv", "results.json", "figures"}
DRAWN = {
    f"{name}.svg"
    for name in ("friction", "calibration", "scale-factors", "validation", "residuals")
}
DAY = "2026-02-03"
NUMBER = "L/2026<14>"


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> Campaign:
    return campaign(tmp_path_factory.mktemp("campaign"))


def made(files: Campaign, out: Path, **more: Any) -> Result:
    given: dict[str, Any] = {
        "friction": files.friction, "pulls": files.pulls, "validate": files.validate,
        "normal_force": NORMAL_FORCE, "date": DAY, "command": "layerjam report x",
        "report_number": NUMBER, "customer": "Ankle Works",
    }  # fmt: skip
    return report(BRAKE, out=out, **(given | more))


@pytest.fixture(scope="module")
def told(files: Campaign, tmp_path_factory: pytest.TempPathFactory) -> tuple[Result, Path]:
    out = tmp_path_factory.mktemp("out") / "deep" / "report"
    return made(files, out), out


@pytest.fixture(scope="module")
def results(told: tuple[Result, Path]) -> dict[str, Any]:
    found = json.loads((told[1] / "results.json").read_text(encoding="utf-8"))
    assert isinstance(found, dict)
    return found


class Page(HTMLParser):
    """Tags, what they load, ids, and the cells of its tables."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: set[str] = set()
        self.loads: list[str] = []
        self.ids: list[str] = []
        self.cells: list[str] = []
        self.words: list[str] = []
        self.inside = False
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)
        self.inside = tag == "td"
        for name, value in attrs:
            assert not name.startswith("on")
            if name in ("src", "srcset", "data", "action") or name.endswith("href"):
                self.loads.append(value or "")
            if name == "id":
                self.ids.append(value or "")

    def handle_data(self, data: str) -> None:
        self.words.append(data)
        if self.inside:
            self.cells.append(data)
            self.inside = False


@pytest.fixture(scope="module")
def page(told: tuple[Result, Path]) -> Page:
    return Page((told[1] / "report.html").read_text(encoding="utf-8"))


def test_what_is_written(told: tuple[Result, Path]) -> None:
    answer, out = told
    assert {p.name for p in out.iterdir()} == FILES
    assert {p.name for p in (out / "figures").iterdir()} == DRAWN
    assert answer.report == str(out / "report.html") and answer.pdf == str(out / "report.pdf")
    assert [p.name for p in out.parent.iterdir()] == ["report"]  # nothing beside it
    assert answer.refused == {} and answer.calibrated_on_the_same == []


def test_the_page_needs_nothing_else(told: tuple[Result, Path], page: Page) -> None:
    text = (told[1] / "report.html").read_text(encoding="utf-8")
    assert not re.search(r"https?:|//[a-z]|@import|@font-face", text)
    assert not page.tags & {"script", "link", "img", "iframe", "object", "embed", "base"}
    assert all(target.startswith("#") for target in page.loads)
    assert len(page.ids) == len(set(page.ids))
    assert {target[1:] for target in page.loads} <= set(page.ids)
    assert set(re.findall(r"url\(#([^)]+)\)", text)) <= set(page.ids)
    assert text.count("<svg") == len(DRAWN) and "prefers-color-scheme: dark" in text
    words = " ".join(page.words)
    assert "Synthetic data" in words and "layerjam report x" in words and DAY in words


def test_figures_are_vector_and_labelled(told: tuple[Result, Path]) -> None:
    for path in (told[1] / "figures").iterdir():
        root = ElementTree.parse(path).getroot()
        assert root.tag.endswith("svg")
        text = path.read_text(encoding="utf-8")
        assert "<image" not in text and len(text) < 400_000
        assert "N" in text


def test_the_pdf_is_as_long_as_it_is(told: tuple[Result, Path]) -> None:
    data = (told[1] / "report.pdf").read_bytes()
    assert data.startswith(b"%PDF") and 2 <= len(re.findall(rb"/Type\s*/Page\b", data)) <= 6


def test_the_number_of_the_report_is_on_every_page(told: tuple[Result, Path], page: Page) -> None:
    """ISO/IEC 17025, 7.8.2.1 d: each page belongs to the report, and its end is clear."""
    import pypdfium2

    with pypdfium2.PdfDocument(told[1] / "report.pdf") as document:
        texts = [document[i].get_textpage().get_text_range() for i in range(len(document))]
    for number, text in enumerate(texts, 1):
        assert f"Report {NUMBER}" in text and f"page {number} of {len(texts)}" in text
    assert f"End of report {NUMBER}" in texts[-1] and "Ankle Works" in texts[0]
    assert "Signature" in texts[-1] and "Verdict: passed" in texts[0]
    html = (told[1] / "report.html").read_text(encoding="utf-8")
    rule = re.search(r'@bottom-left { content:"([^"]*)"', html)
    assert rule is not None and "<" not in rule.group(1)
    shown = re.sub(r"\\([0-9a-f]{6})", lambda m: chr(int(m.group(1), 16)), rule.group(1))
    assert shown == f"Report {NUMBER}" and f"End of report {NUMBER}" in "".join(page.words)


def test_a_table_that_continues_repeats_its_header() -> None:
    """A hundred pulls on several pages: each of these pages names the columns."""
    import io

    import pypdfium2

    from layerjam.core.drawing.page import Page as Content
    from layerjam.core.drawing.page import Part, Table, typeset_pdf

    rows = [[str(n), f"pull-{n}.csv", "ok"] for n in range(1, 101)]
    table = Table(id="pulls", caption="Each pull", head=["no.", "file", "verdict"], rows=rows)
    content = Content(
        title="t", lead="", parts=[Part(id="p", title="P", tables=[table])], footer="f",
        mark="Report 1", more={"date": DAY},
    )  # fmt: skip
    with pypdfium2.PdfDocument(io.BytesIO(typeset_pdf(content.template_data(), {}))) as document:
        texts = [document[i].get_textpage().get_text_range() for i in range(len(document))]
    with_rows = [text for text in texts if "pull-" in text.replace("\u200b", "")]
    assert len(with_rows) > 1
    text = "".join(texts).replace("\u200b", "")
    assert [int(n) for n in re.findall(r"pull-(\d+)", text)] == list(range(1, 101))
    assert all("no." in text and "verdict" in text for text in with_rows)


def test_the_headline_is_the_expanded_uncertainty_of_the_budget(
    page: Page, results: dict[str, Any]
) -> None:
    """GUM, 7.2.6: two significant digits, and the value to the same decimal; k beside it."""
    numbers = {n["quantity"]: n["value"] for n in results["numbers"]}
    words = " ".join(page.words)
    for what, value in (
        ("the scale factor", numbers["calibration: scale factor a"]),
        ("a × kinetic friction", numbers["calibration: a × kinetic friction"]),
    ):
        stem = f"uncertainty of {what}"
        reach = numbers[f"{stem}, expanded"] * value
        decimals = int(f"{reach:.1e}".split("e-")[1]) + 1
        assert f"{value:.{decimals}f} ± {reach:.{decimals}f}" in words
        factor, degrees = (
            numbers[f"{stem}, {n}"] for n in ("coverage factor k", "degrees of freedom")
        )
        assert f"k = {factor:.2f}, ν = {degrees:.1f}" in words
        assert factor >= stats.t.ppf(0.975, degrees) * (1 - 1e-9)  # or that of one line alone
        assert numbers[f"{stem}, expanded"] == pytest.approx(numbers[f"{stem}, combined"] * factor)
    assert "load_cell_limit in each friction test's sidecar" in words
    assert numbers["uncertainty of the scale factor, combined"] ** 2 == pytest.approx(
        numbers["uncertainty of a × kinetic friction, combined"] ** 2
        + numbers["uncertainty of the scale factor: friction tests, contribution"] ** 2
    )


def test_each_pull_has_one_row(told: tuple[Result, Path], results: dict[str, Any]) -> None:
    """Peak, scale factor and comparison of a pull stand in one table, each number once."""
    text = (told[1] / "report.html").read_text(encoding="utf-8")
    assert text.count("<caption>Individual pulls</caption>") == 2 and "Pull by pull" not in text
    names = {n["quantity"] for n in results["numbers"] if n["source"] == "pull-1.csv"}
    own = ("vacuum", "speed", "peak force", "scale factor a", "stiffness k", "shape", "seating")
    assert names >= {f"calibration pull: {name}" for name in own}
    assert not any("pull by pull" in name for name in names)


def test_the_csv_holds_what_the_json_holds(
    told: tuple[Result, Path], results: dict[str, Any]
) -> None:
    with (told[1] / "numbers.csv").open(encoding="utf-8", newline="") as handle:
        rows = list(csv.DictReader(handle))
    assert tuple(rows[0]) == COLUMNS and len(rows) == len(results["numbers"])
    for row, entry in zip(rows, results["numbers"], strict=True):
        for name in COLUMNS:
            cell, value = row[name], entry[name]
            if value is None:
                assert cell == ""
            elif isinstance(value, str):
                assert cell == value
            else:
                assert float(cell) == value
    names = [(r["quantity"], r["source"]) for r in rows]
    assert len(set(names)) == len(names)


def test_every_number_of_the_tables_is_in_the_csv(page: Page, results: dict[str, Any]) -> None:
    shown = set()
    for row in results["numbers"]:
        for scale in (1.0, 1e2, 1e-3, 1e3):
            for key in ("value", "low", "high", "standard_error"):
                if row[key] is not None:
                    shown |= {f"{abs(row[key]) * scale:.{n}f}" for n in range(7)}
                    shown.add(f"{abs(row[key]) * scale:.4g}")
        shown.add(str(row["n"]))
    numeric = [c for c in page.cells if re.fullmatch(r"[−\d.]+( (to|N|%|kPa|mm|kN/m).*)?", c)]
    assert len(numeric) > 100
    for cell in numeric:
        for number in re.findall(r"\d+(?:\.\d+)?", cell):
            assert number in shown, cell


def test_numbers_are_those_of_the_verbs(results: dict[str, Any]) -> None:
    numbers = {r["quantity"]: r for r in results["numbers"]}
    friction, calibration = results["friction"], results["calibration"]
    validation = results["validation"]
    assert numbers["friction: kinetic, mean"]["value"] == friction["kinetic"]
    assert numbers["friction: kinetic, standard deviation"]["value"] == friction["kinetic_sd"]
    factor = numbers["calibration: scale factor a"]
    assert factor["value"] == calibration["scale_factor"]
    assert factor["standard_error"] == calibration["standard_errors"]["scale_factor"]
    assert factor["low"] < factor["value"] < factor["high"] and factor["n"] == 3
    product = numbers["calibration: a × kinetic friction"]["value"]
    assert product == pytest.approx(0.875 * 0.24, rel=0.05)
    assert numbers["validation, all: MAPE, calibrated"]["value"] == validation["mape"]
    before = numbers["validation, all: MAPE, before calibration"]["value"]
    assert before == validation["uncalibrated"]["mape"] > validation["mape"]
    for row in validation["conditions"]:
        parts = row["scatter"]
        assert parts["model_mse"] + parts["scatter_mse"] == pytest.approx(parts["mse"])
        assert row["repeats"] == 2


def test_provenance(files: Campaign, results: dict[str, Any]) -> None:
    import hashlib

    every = [*files.friction, *files.pulls, *files.validate]
    digests = {p.name: hashlib.sha256(p.read_bytes()).hexdigest() for p in every}
    assert {f["name"]: f["sha256"] for f in results["files"]} == digests
    assert {f["role"] for f in results["files"]} == {"friction", "calibration", "validation"}
    assert results["synthetic"] is True and results["date"] == DAY


@pytest.mark.slow
def test_the_same_input_gives_the_same_bytes(
    told: tuple[Result, Path], files: Campaign, tmp_path: Path
) -> None:
    _, first = told
    made(files, tmp_path / "again")
    made(files, tmp_path / "later", date="2026-02-04")
    for path in sorted(p for p in first.rglob("*") if p.is_file()):
        inside = path.relative_to(first)
        assert (tmp_path / "again" / inside).read_bytes() == path.read_bytes(), inside
        later = (tmp_path / "later" / inside).read_bytes()
        if path.suffix in (".html", ".json"):
            assert later.replace(b"2026-02-04", DAY.encode()) == path.read_bytes()
        elif path.suffix != ".pdf":
            assert later == path.read_bytes()


def test_whole_or_not_at_all(
    files: Campaign, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(writer, "draw_all", draw_nothing)
    monkeypatch.setattr(writer, "typeset_pdf", lambda data, pictures: b"%PDF")
    out = tmp_path / "out"
    out.mkdir()
    (out / "mine.txt").write_text("mine")
    made(files, out, validate=())
    assert {p.name for p in out.iterdir()} == {*FILES, "mine.txt"}
    before = {p: p.read_bytes() for p in out.rglob("*") if p.is_file()}
    with pytest.raises(FileError, match="already exists; --overwrite replaces it"):
        made(files, out, validate=())
    assert {p: p.read_bytes() for p in out.rglob("*") if p.is_file()} == before
    made(files, out, pulls=(), validate=(), overwrite=True)  # friction alone
    assert {p.name for p in (out / "figures").iterdir()} == {"friction.svg"}
    assert (out / "mine.txt").read_text() == "mine"
    assert [p.name for p in tmp_path.iterdir()] == ["out"]
    wall = tmp_path / "wall"
    wall.write_text("")
    for place in (wall, wall / "report"):
        with pytest.raises(FileError):
            made(files, place)


def test_without_typst(files: Campaign, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "typst", None)
    answer = made(files, tmp_path / "out", pulls=(), validate=())
    assert answer.pdf is None and not (tmp_path / "out" / "report.pdf").exists()
    assert (tmp_path / "out" / "report.html").exists()
    assert any("[pdf]" in w for w in answer.warnings)


@pytest.mark.parametrize(
    ("number", "text", "error", "interval"),
    [
        (Number(quantity="k", value=131e3, unit="N/m", standard_error=832.0, low=129e3, high=133e3),
         "131.00 kN/m", "0.83 kN/m", "129.00 to 133.00 kN/m"),
        (Number(quantity="a", value=0.87412, unit="1", standard_error=0.0123),
         "0.874", "0.012", "–"),
        (Number(quantity="b", value=-0.0456, unit="1", shown_in="%", decimals=1), "−4.6 %", "–",
         "–"),
        (Number(quantity="z", value=-1e-9, unit="N", decimals=2, shown_in="N"), "0.00 N", "–", "–"),
        (Number(quantity="n", value=None, unit="N"), "–", "–", "–"),
        (Number(quantity="n", value=float("nan"), unit="N"), "–", "–", "–"),
    ],
)  # fmt: skip
def test_numbers_as_a_page_shows_them(number: Number, text: str, error: str, interval: str) -> None:
    assert (number.text(), number.error_text(), number.interval_text()) == (text, error, interval)


def test_a_live_report_computes_and_has_the_same_numbers(
    told: tuple[Result, Path], files: Campaign, tmp_path: Path
) -> None:
    made(files, tmp_path / "live", live=True)
    for name in ("numbers.csv", "results.json", "report.pdf"):
        assert (told[1] / name).read_bytes() == (tmp_path / "live" / name).read_bytes()
    text = (tmp_path / "live" / "report.html").read_text(encoding="utf-8")
    page = Page(text)
    assert page.loads == Page((told[1] / "report.html").read_text("utf-8")).loads
    assert len(page.ids) == len({*page.ids}) and text.count("<script") == 1
    assert "default-src 'none'" in text and "script-src 'sha256-" in text
    results = json.loads((tmp_path / "live" / "results.json").read_text("utf-8"))
    factor, friction = results["calibration"]["scale_factor"], results["friction"]["kinetic"]
    contact = float(re.search(r'"numbers":\[([^,]+),', text)[1])  # type: ignore[index]
    assert contact == pytest.approx(factor * friction * 10 * 0.013, rel=1e-5)
