"""Stop in a browser: what is copied and pinned afterwards is what the chart still shows."""

from __future__ import annotations

import pytest

from workbench.access import LONG, opened, unfolded

pytestmark = pytest.mark.slow
FEW, MANY, OTHER = "1000", "1000000", "2000"
"""Stacks whose friction scatters: quickly computed, long enough to be stopped, and others."""


def at(key: str) -> str:
    return f"[data-testid=pull-{key}]"


def ask(tab, samples: str) -> None:
    field = tab.locator(at("samples"))
    field.fill(samples)
    field.press("Enter")


def test_a_stopped_pull_leaves_figure_python_and_pin_as_one(tab, workbench, tmp_path, monkeypatch):
    settings = {"model": "stack", "scatter": "10 %", "samples": FEW, "travel": 5e-3}
    opened(tab, workbench, "pull", settings)
    tab.get_by_text("Pulled to 5 mm").wait_for(timeout=4 * LONG)
    tab.wait_for_selector(at("stop"), state="hidden", timeout=LONG)
    unfolded(tab)
    peak = tab.inner_text(at("peak_force"))
    ask(tab, MANY)
    tab.click(at("stop"), timeout=LONG)
    tab.get_by_text("stopped", exact=True).wait_for(timeout=LONG)
    assert tab.locator(at("samples")).input_value() == MANY
    assert tab.inner_text(at("peak_force")) == peak
    # the Python under the chart, and that of the header
    for place in (at("python"), "[data-testid=copy-as-python]"):
        tab.click(place)
        lines = tab.inner_text("[data-testid=copied] code", timeout=LONG).replace("\xa0", " ")
        assert f'samples="{FEW}"' in lines and MANY not in lines
        tab.get_by_role("button", name="Close").click()
    monkeypatch.chdir(tmp_path)
    space: dict[str, object] = {}
    exec(lines, space)
    assert f"{space['result'].peak_force:.3g} N" in peak
    assert (tmp_path / "tensile.svg").exists()
    # the pin belongs to the shown pull: beside the next one its samples are what differs
    tab.click(at("pin"))
    ask(tab, OTHER)
    tab.click(at("stop"), timeout=LONG)
    tab.locator(at("pins")).get_by_text(FEW).wait_for(timeout=4 * LONG)
    assert tab.errors == []
