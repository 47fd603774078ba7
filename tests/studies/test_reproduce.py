"""The report: one page that needs nothing else, a list of claims, and figures."""

from __future__ import annotations

import json
import re
import shutil
from html.parser import HTMLParser
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from core.drawing.legible import faults
from docs.test_pages import compare_keys
from layerjam.cli.main import main
from layerjam.core.drawing import page
from layerjam.core.drawing.style import format_svg
from layerjam.studies.choi2018.reproduce import reproduce

pytestmark = pytest.mark.slow
KEYS = ["claim", "section", "paper", "ours", "unit", "verdict", "because", "why", "again"]
VERDICTS = (
    "reproduced", "consistent", "by construction", "differs", "not reproducible", "ours to explain"
)  # fmt: skip
AGREES = VERDICTS[:3]
# Half of the last digit printed, or what the row says; a second time, without looking at src.
TOLERANCE = {
    r"leaving 8 mm of overlap": 0.5,
    r"eq\. 6: stiffness while sliding, (Kapton|PTFE)": 5.0,
    r"pressure of the friction test": 0.05,
    r"table I: static friction, Kapton": 0.32 * 0.0818,
    r"table I: kinetic friction, Kapton": 0.24 * 0.0277,
    r"table I: static friction, PTFE": 0.12 * 0.0871,
    r"table I: kinetic friction, PTFE": 0.05 * 0.0317,
    r"(scale factor|eq\. 8 gives it), Kapton": 0.0005,
    r"(scale factor|eq\. 8 gives it), PTFE": 0.005,
    r"(stiffness from the slope|eq\. 9 gives it), (Kapton|PTFE)": 0.5,
    r"text and caption of Fig\. 8 agree": 0.5,
    r"full vacuum gives about 20 % of 50 g": 0.5,
    r"tuned vacuum stays under 2 g": 0.5,
    r"travel is always 40 mm": 0.5,
    r"one more sheet adds force": 0.05,
    r"one more sheet adds mass": 0.05,
}


ILLEGIBLE: list[str] = []
"""What is wrong with the figures of the page, found as they are drawn."""


def measured(figure: Any) -> str:
    """Measured afterwards: a figure that was laid out before is drawn a little differently."""
    dots = figure.get_dpi()
    text = format_svg(figure)
    figure.set_dpi(dots)
    ILLEGIBLE.extend(faults(figure))
    return text


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("reproduction") / "report"
    told: list[str] = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(page, "format_svg", measured)
        made = reproduce(out, progress=lambda what, _: told.append(what))
    assert (made.report, made.results) == (str(out / "report.html"), str(out / "results.json"))
    assert any("synthetic" in line for line in told) and made.report in told[-1]
    rows = json.loads(Path(made.results).read_text(encoding="utf-8"))
    counts = {v: made.values[v] for v in VERDICTS}
    once = [r for r in rows if not r["again"]]
    assert counts == {v: sum(r["verdict"] == v for r in once) for v in VERDICTS}
    assert sum(counts.values()) == len(once) == len(rows) - 4
    return out


@pytest.fixture(scope="module")
def rows(folder: Path) -> list[dict[str, Any]]:
    found = json.loads((folder / "results.json").read_text(encoding="utf-8"))
    assert isinstance(found, list)
    return found


class Page(HTMLParser):
    """Tags, what they load, and the text of the page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.loads: list[str] = []
        self.ids: list[str] = []
        self.links: list[str] = []
        self.words: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        for name, given in attrs:
            value = given or ""
            assert not name.startswith("on"), f"{tag} {name}"
            if name in ("src", "srcset", "data", "poster", "action") or name.endswith("href"):
                (self.links if value.startswith("#") else self.loads).append(value)
            if name == "id":
                self.ids.append(value)
            for inner in re.findall(r"url\(([^)]*)\)", value):
                (self.links if inner.startswith("#") else self.loads).append(inner)

    def handle_data(self, data: str) -> None:
        self.words.append(data)


def test_keys_and_verdict_words(rows: list[dict[str, Any]]) -> None:
    assert len(rows) >= 40
    for row in rows:
        assert list(row) == KEYS, row
        assert row["verdict"] in VERDICTS
        for key in ("claim", "section", "unit", "verdict", "because", "why", "again"):
            assert isinstance(row[key], str)
        assert row["claim"] and row["section"]
        for key in ("paper", "ours"):
            assert row[key] is None or isinstance(row[key], float | str)
        assert len(row["because"]) > 10, row
        if row["verdict"] not in AGREES:
            assert len(row["why"]) > 10, row
    assert len({row["claim"] for row in rows}) == len(rows)


def test_verdicts_follow_from_the_numbers(rows: list[dict[str, Any]]) -> None:
    judged = [
        row for row in rows
        if row["verdict"] != "not reproducible"
        and isinstance(row["paper"], float) and isinstance(row["ours"], float)
    ]  # fmt: skip
    assert len(judged) >= 20
    unknown = []
    for row in judged:
        bounds = [t for pattern, t in TOLERANCE.items() if re.search(pattern, row["claim"])]
        if len(bounds) != 1:
            unknown.append(row["claim"])
            continue
        same = abs(row["ours"] - row["paper"]) <= bounds[0]
        assert (row["verdict"] in AGREES) is same, row
        if not same:
            off = f"{(row['ours'] - row['paper']) / row['paper']:+.1%}"
            assert row["why"].startswith(off), row
    # claims of later parts come with their own tolerance; those above must all be judged
    assert len(judged) - len(unknown) >= 20, unknown
    for row in (r for r in judged if r["claim"] in unknown):
        near = abs(row["ours"] / row["paper"] - 1) < 0.1
        assert near or row["verdict"] == "differs", row


def test_only_two_printed_numbers_come_out_of_others(rows: list[dict[str, Any]]) -> None:
    """What an attack on the first tally found, which called 23 claims reproduced."""
    found = {v: {r["claim"] for r in rows if r["verdict"] == v} for v in VERDICTS}
    ours = {r["claim"]: r["ours"] for r in rows}
    assert found["reproduced"] == {"one more sheet adds force", "one more sheet adds mass"}
    # by hand, from other printed numbers: a mu_k P W L2, less what onset leaves, and DuPont's 1.42
    onset = 175.925 / 131e3
    assert ours["one more sheet adds force"] == pytest.approx(
        0.875 * 0.24 * 94.5e3 * 0.013 * (0.068 - onset), rel=0.02
    )
    assert ours["one more sheet adds mass"] == pytest.approx(1.42e-3 * 85 * 13 * 0.254, abs=2e-3)
    arithmetic = {
        "stretches up to about 60 mm, leaving 8 mm of overlap", "water is faster by a factor",
        "pressure of the friction test",
    }  # fmt: skip
    assert arithmetic <= found["consistent"]
    assert found["consistent"] - arithmetic == {
        "in compression the brake buckles", "Fig. 4: Kapton resists more than PTFE",
        "the enclosure contributes very minimally to the force at the peak",
    }  # fmt: skip
    went_in = [
        r for r in rows if re.search(r"table I:|scale factor, |the slope,|eq\. 6:", r["claim"])
    ]
    assert len(went_in) == 10 and {r["verdict"] for r in went_in} == {"by construction"}
    assert found["ours to explain"] == {
        "eq. 8 gives it, Kapton", "eq. 9 gives it, Kapton", "eq. 9 gives it, PTFE",
        "Fig. 4: Kapton and polyester judder at 1 mm/s, PTFE hardly does",
    }  # fmt: skip
    again = {r["claim"]: r["again"] for r in rows if r["again"]}
    assert len(again) == 4 and set(again.values()) <= set(ours) - set(again)


def test_the_rest_of_the_error_is_47_percent(rows: list[dict[str, Any]]) -> None:
    rest = 1 - (abs(1 / 0.875 - 1) + abs(1 / 1.24 - 1)) / 2 / 0.32
    why = next(r["why"] for r in rows if "explains the error" in r["claim"])
    assert f"{rest:.0%} of it has another cause" in why and f"{rest:.0%}" == "47%"


def test_the_enclosures_share_of_the_peak_and_the_makers_of_fig_12(
    rows: list[dict[str, Any]],
) -> None:
    """The share by hand: e sqrt(x) over c L2 + e^2/4c, at the peak's slip and at its elongation."""
    shares = []
    for factor, kinetic, silicone, k in ((0.875, 0.24, 0.80, 131e3), (1.24, 0.05, 0.23, 55e3)):
        c = factor * kinetic * 10 * 0.013 * 94.5e3
        e = 2 * (0.1e6 * 0.013 * 0.001 * 94.5e3 * silicone * 0.013) ** 0.5
        peak = c * 0.068 + e**2 / 4 / c
        slip = (e / 2 / c) ** 2
        shares += [e * slip**0.5 / peak, e * (slip + peak / k) ** 0.5 / peak]
    row = next(r for r in rows if "very minimally" in r["claim"])
    assert row["ours"] == f"{shares[0]:.1%} and {shares[2]:.1%}"
    assert f"{shares[1]:.1%} and {shares[3]:.1%}" in row["why"]
    row = next(r for r in rows if r["claim"].startswith("standard deviation of the MAPE"))
    assert (row["paper"], row["verdict"]) == (3.7, "not reproducible") and row["ours"] > 0
    row = next(r for r in rows if "largest of four kinds" in r["claim"])
    for maker in ("ITT Enidine", "Airpot", "Alkan et al."):
        assert maker in row["why"]


def test_the_list_of_section_7_is_on_the_page(rows: list[dict[str, Any]]) -> None:
    text = " ".join(f"{row['claim']} {row['why']} {row['ours']}" for row in rows)
    for words in (
        "x belongs inside the root", "caption", "the same caps and rig cannot be both", "17.9",
        "eq. 10 leaves out the work of gravity", "1.06 and 3.58 kPa", "234 N against 176 N",
        "contradicts itself", "14% and 19%", "26 times", "raw curves are not published",
        "does not state them",
    ):  # fmt: skip
        assert words in text, words


def test_the_page_needs_nothing_else(folder: Path) -> None:
    text = (folder / "report.html").read_text(encoding="utf-8")
    page = Page(text)
    assert page.loads == []
    assert not {"script", "iframe", "link", "object", "embed", "img", "base"} & set(page.tags)
    assert "@import" not in text and "javascript:" not in text
    for address in re.findall(r"https?://[^\"'\s<)]+", text):
        assert address.startswith("http://www.w3.org/"), address  # names of XML, never loaded
    assert len(page.ids) == len(set(page.ids))
    missing = {link[1:] for link in page.links} - set(page.ids)
    assert missing == set()


def test_the_page_holds_every_row_and_figure(folder: Path, rows: list[dict[str, Any]]) -> None:
    text = (folder / "report.html").read_text(encoding="utf-8")
    words = " ".join(Page(text).words)
    for row in rows:
        assert row["claim"] in words and row["why"] in words and row["because"] in words
    figures = sorted((folder / "figures").glob("*.svg"))
    assert text.count("<svg") == len(figures) >= 7
    assert text.count("<figcaption>") == len(figures)
    assert "synthetic" in words


def test_no_word_of_a_figure_hides_another_and_axes_have_units(folder: Path) -> None:
    assert folder.is_dir() and ILLEGIBLE == []


def test_figures_are_whole_svg(folder: Path) -> None:
    names = {p.stem for p in (folder / "figures").iterdir()}
    assert {"fig4", "fig7-9", "fig8", "eq5", "closing", "sheets"} <= names
    for path in (folder / "figures").iterdir():
        root = ElementTree.fromstring(path.read_text(encoding="utf-8"))
        assert root.tag.endswith("svg") and len(list(root.iter())) > 50


def test_nothing_else_is_left_behind(folder: Path) -> None:
    assert {p.name for p in folder.iterdir()} == {"report.html", "results.json", "figures"}


@pytest.mark.parametrize("name", ["report.html", "results.json"])
def test_an_old_report_stays(tmp_path: Path, name: str, capfd: pytest.CaptureFixture[str]) -> None:
    (tmp_path / name).write_text("mine")
    assert main(["reproduce", "--out", str(tmp_path)]) == 2
    out, err = capfd.readouterr()
    assert out == "" and err.count("\n") == 1 and "already exists; --overwrite" in err
    assert [p.name for p in tmp_path.iterdir()] == [name]
    assert (tmp_path / name).read_text() == "mine"


@pytest.mark.slow
def test_the_command_twice_gives_the_same(
    folder: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "report"
    shutil.copytree(folder, out)
    (out / "report.html").write_text("an older one", encoding="utf-8")
    assert main(["reproduce", "--out", str(out), "--overwrite", "--json"]) == 0
    compare_keys("reproduce", json.loads(capfd.readouterr().out))
    for path in sorted(folder.rglob("*.*")):
        again = out / path.relative_to(folder)
        assert again.read_bytes() == path.read_bytes(), path.name
