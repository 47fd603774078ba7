"""Equations of README and docs: all can be typeset, and none fetches anything."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import pytest

from docs.examples import ROOT, script

pytest.importorskip("latex2mathml")
equations = script(ROOT / "docs" / "equations.py")
MATHML = "{http://www.w3.org/1998/Math/MathML}"
"""The name of the language; no address that a browser opens."""
PARTS = {"mfrac": 2, "mover": 2, "msub": 2, "msup": 2, "munder": 2, "msubsup": 3, "munderover": 3}
"""How many parts an element has; with another number browsers show something else."""
ELEMENTS = re.compile(
    r"m(?:ath|frac|i|n|o|over|row|space|sqrt|style|sub|subsup|sup|text|under|underover)"
)
ATTRIBUTES = re.compile(
    r"accent|display|displaystyle|fence|form|[lr]space|mathvariant|scriptlevel|stretchy|width"
)
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]


def shown(element: ElementTree.Element) -> str:
    """What a reader sees, in one line."""
    return "".join(element.itertext()).replace("\u2212", "-").replace("\xa0", " ")


def test_every_equation_is_typeset_and_fetches_nothing() -> None:
    seen = 0
    for page in PAGES:
        for latex, block in equations.equations(page.read_text(encoding="utf-8")):
            tree = ElementTree.fromstring(equations.mathml(latex, block=block))
            for part in tree.iter():
                assert part.tag.startswith(MATHML), latex
                assert ELEMENTS.fullmatch(part.tag.removeprefix(MATHML)), latex
                assert all(ATTRIBUTES.fullmatch(name) for name in part.attrib), latex
                name = part.tag.removeprefix(MATHML)
                assert len(part) == PARTS.get(name, len(part)), latex
            letters = re.findall(r"(?<![a-zA-Z\\{])[a-zA-Z](?![a-zA-Z])", latex)
            assert all(letter in shown(tree) for letter in letters), latex
            seen += 1
    assert seen > 400


def test_no_dollar_is_left_over() -> None:
    """An equation that the finder misses would stand in the page as LaTeX."""
    for page in PAGES:
        text = equations.FENCED.sub("", page.read_text(encoding="utf-8"))
        text = re.sub(r"^::: .*\n(?:    .*\n)*", "", text, flags=re.MULTILINE)
        assert "$" not in equations.EQUATION.sub("", text), page.name


def test_a_logarithm_carries_its_base() -> None:
    tree = ElementTree.fromstring(equations.mathml(r"B \log_{10}(t/t_0)"))
    base = next(part for part in tree.iter(f"{MATHML}msub") if shown(part) == "log10")
    assert [shown(part) for part in base] == ["log", "10"]


def test_subscripts_roots_and_functions_come_out_as_written() -> None:
    peak = equations.mathml(r"F_\text{peak} = c L_2 + \frac{e^2}{4 c}", block=True)
    assert "<msub><mi>F</mi><mtext>peak</mtext></msub>" in peak
    tree = ElementTree.fromstring(peak)
    over, under = tree.find(f".//{MATHML}mfrac") or ()
    assert (shown(over), shown(under)) == ("e2", "4c")
    assert tree.get("display") == "block"
    root = ElementTree.fromstring(equations.mathml(r"\sqrt{EA q x}"))
    assert shown(root.find(f".//{MATHML}msqrt")) == "EAqx"
    assert "<mtext>d</mtext>" in equations.mathml(r"\mathrm{d} x")  # upright, not italic


@pytest.mark.parametrize(
    "wrong",
    [r"\foo x", r"\frac{a", r"a \, b", "x*y", r"\{a\}", r"\begin{aligned} a &= b \end{aligned}"],
)
def test_what_a_browser_or_github_would_show_wrongly_stops_the_build(wrong: str) -> None:
    with pytest.raises(equations.EquationError):
        equations.mathml(wrong)


def test_a_long_equation_in_a_line_breaks_where_tex_breaks() -> None:
    latex = r"F = M g + \sqrt{(F_0 - M g)^2 + k_\text{rope} M v^2}"
    parts = equations.pieces(latex)
    assert [p.strip() for p in parts[:2]] == ["F =", "M g +"] and len(parts) == 3
    assert "".join(parts) == latex
    page = f'<p>(<span class="arithmatex">\\({latex}\\)</span>), and</p>'
    made = equations.typeset(page)
    assert made.count("<math ") == 3 and made.endswith("</math>),</span> and</p>")
    assert made.startswith('<p><span class="kept">(<math ')  # a bracket stays with what it opens
