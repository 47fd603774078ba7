"""The wiring of a board: what is drawn is what its file says, and each conflict is found."""

from __future__ import annotations

import json
import re
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path

import pytest

from layerjam.cli.main import main
from layerjam.report.wiring import drawing
from layerjam.rig.circuit import PICO, Circuit, load_circuit, ohms

# Raspberry Pi Pico's datasheet, figure 4: GP numbers around the socket, from pin 1 on
AROUND = re.findall(
    r"\S+",
    "0 1 GND 2 3 4 5 GND 6 7 8 9 GND 10 11 12 13 GND 14 15 16 17 GND 18 19 20 21 GND 22 RUN 26 27 "
    "AGND 28 ADC_VREF 3V3 3V3_EN GND VSYS VBUS",
)


@pytest.fixture
def made() -> Circuit:
    return load_circuit("pico")


def test_the_socket_is_the_picos(made: Circuit) -> None:
    assert len(AROUND) == made.pins == 40
    for pin, name in enumerate(AROUND, 1):
        if name == "GND":
            assert pin in made.grounds
        else:
            assert made.socket[f"GP{name}" if name.isdigit() else name] == pin


def test_every_wire_is_drawn_with_its_pin_and_parts(made: Circuit) -> None:
    assert made.conflicts() == ()
    svg = drawing(made)
    texts = {node.text for node in ET.fromstring(svg).iter() if node.tag.endswith("text")}
    for wire in made.wires:
        assert {wire.label, f"pin {wire.pin}", wire.to, wire.name} <= texts
        assert {wire.series, wire.shunt} - {None} <= texts
    assert any("pull-downs" in (text or "") for text in texts)
    assert any("Without power the vent" in (text or "") for text in texts)


def test_the_page_shows_this_drawing(made: Circuit) -> None:
    """After a change: layerjam bench wiring pico --out docs/images/wiring-pico.svg."""
    page = Path(__file__).parents[2] / "docs" / "images" / "wiring-pico.svg"
    assert page.read_text("utf-8") == drawing(made)


def test_nothing_is_drawn_outside_of_the_sheet(made: Circuit) -> None:
    """Letters are taken for 0.62 of their size wide, which no sans serif exceeds on average."""
    root = ET.fromstring(drawing(made))
    wide, high = float(root.get("width", "0")), float(root.get("height", "0"))
    sizes = {"big": 20, "head": 15, "small": 11}
    for node in root.iter():
        if not node.tag.endswith("text"):
            continue
        kinds = (node.get("class") or "").split()
        size = next((sizes[kind] for kind in kinds if kind in sizes), 13)
        x, y = float(node.get("x", "0")), float(node.get("y", "0"))
        length = 0.62 * size * len(node.text or "")
        begin = x - (length if "end" in kinds else length / 2 if "mid" in kinds else 0)
        assert begin >= 0 and begin + length <= wide and 0 < y <= high, node.text


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('shunt = "8.2 kΩ"', 'shunt = "10 kΩ"', "needs a pull-down"),
        ('shunt = "8.2 kΩ"', "", "has none"),
        ('shunt = "30 kΩ, 47 nF"', 'shunt = "68 kΩ"', "5.10 V reach GP18"),
        ('series = "10 kΩ"', "", "4.50 V reach GP27"),
    ],
)
def test_parts_that_cannot_be(tmp_path: Path, old: str, new: str, said: str) -> None:
    text = PICO.read_text("utf-8")
    assert old in text
    other = tmp_path / "other.toml"
    other.write_text(text.replace(old, new), encoding="utf-8")
    assert any(said in one for one in load_circuit("pico", other).conflicts())


@pytest.mark.parametrize(
    ("pins", "said"),
    [
        ({"sync_out": 24}, "GP24 leads to no pin"),
        ({"pump_back_gate": 0, "spi_miso": 4, "spi_mosi": 7}, "one PWM channel"),
        ({"spi_miso": 5}, "another pin of SPI"),
        ({"spi_miso": 8}, "two different ports"),
    ],
)
def test_pins_that_cannot_be(made: Circuit, pins: dict[str, int], said: str) -> None:
    wiring = made.file.wiring
    changed = replace(made.file, wiring=replace(wiring, pins=replace(wiring.pins, **pins)))
    assert any(said in one for one in replace(made, file=changed).conflicts())


def test_ohms() -> None:
    assert [ohms(t) for t in ("8.2 kΩ", "150 Ω, 10 nF", "1 Mohm", "10 nF", None)] == [
        8200.0,
        150.0,
        1e6,
        None,
        None,
    ]


def test_as_it_is_typed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "wiring.svg"
    assert main(["bench", "wiring", "pico", "--out", str(out), "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["conflicts"] == [] and out.read_text("utf-8").startswith("<svg")
    pins = {wire["use"]: wire["pin"] for wire in said["pins"]}
    assert pins["pump_gate"] == 21 and pins["vent_gate"] == 22
    assert main(["bench", "wiring", "pico", "--out", str(out)]) == 2
    assert re.search("is there already", capsys.readouterr().err)
    assert main(["bench", "wiring", "arduino"]) == 2
