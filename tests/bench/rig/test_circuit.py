"""The wiring of a board: what is drawn is what its file says, and each conflict is found."""

from __future__ import annotations

import json
import re
import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path

import pytest

from layerjam.bench.figures.wiring_diagram import draw_wiring
from layerjam.bench.rig.circuit import PICO, Circuit, load_circuit
from layerjam.bench.rig.electronics import find_conflicts
from layerjam.cli.main import main

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


def words(svg: str) -> list[str]:
    """Lines of text of a drawing."""
    root = ET.fromstring(svg)
    return ["".join(n.itertext()).strip() for n in root.iter() if n.tag.endswith(("text", "tspan"))]


def test_every_wire_and_component_is_drawn(made: Circuit) -> None:
    assert find_conflicts(made) == ()
    said = words(draw_wiring(made))
    text = "\n".join(said)
    for wire in made.wires:
        assert (wire.use or wire.label) in said, wire
    for ref, component in made.components.items():
        assert ref in said or any(one.startswith(f"{ref} ") for one in said) or ref in text, ref
        if component.kind in ("resistor", "capacitor"):
            assert component.text in text, component
    for number in range(1, made.pins + 1):
        assert str(number) in said
    for part in made.parts:
        assert part.number in text
    assert "pull-downs" in text and "Unpowered, the vent" in text and "H-bridge" in text


def test_every_drawn_part_is_of_the_declaration(made: Circuit) -> None:
    """A part that is drawn and not declared would be neither calculated nor simulated."""
    drawn = {one for one in words(draw_wiring(made)) if re.fullmatch(r"[A-Z]\d+", one)}
    assert drawn <= set(made.components), drawn - set(made.components)


def test_the_page_shows_this_drawing(made: Circuit) -> None:
    """After a change: make pictures."""
    page = Path(__file__).parents[3] / "docs" / "images" / "wiring-pico.svg"
    assert page.read_text("utf-8") == draw_wiring(made)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("value = 8200.0", "value = 10000.0", "needs a pull-down"),
        ('nodes = ["pump gate", "GND"]', 'nodes = ["other", "GND"]', "has none"),
        ("value = 20000.0", "value = 47000.0", "voltage at accelerometer_adc: 3.7"),
        (
            "value = 30000.0\ntolerance = 0.01",
            "value = 68000.0\ntolerance = 0.01",
            "at estop_sense: 5",
        ),
    ],
)
def test_parts_that_cannot_be(tmp_path: Path, old: str, new: str, said: str) -> None:
    text = PICO.read_text("utf-8")
    assert old in text
    other = tmp_path / "other.toml"
    other.write_text(text.replace(old, new), encoding="utf-8")
    assert any(said in one for one in find_conflicts(load_circuit("pico", other)))


@pytest.mark.parametrize(
    ("pins", "said"),
    [
        ({"sync_out": 24}, "GP24 is not connected to a pin"),
        ({"pump_back_gate": 0, "spi_miso": 4, "spi_mosi": 7}, "one PWM channel"),
        ({"spi_miso": 5}, "a different SPI pin"),
        ({"spi_miso": 8}, "two different ports"),
    ],
)
def test_pins_that_cannot_be(made: Circuit, pins: dict[str, int], said: str) -> None:
    wiring = made.file.wiring
    changed = replace(made.file, wiring=replace(wiring, pins=replace(wiring.pins, **pins)))
    assert any(said in one for one in replace(made, file=changed).list_conflicts())


def test_values_are_written_with_their_units(made: Circuit) -> None:
    parts = made.components
    shown = [parts[ref].text for ref in ("R2", "R1", "R5", "C1", "C3")]
    assert shown == ["8.2 kΩ", "300 Ω", "100 kΩ", "1000 µF", "47 nF"]


def test_as_it_is_typed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "wiring.svg"
    assert main(["bench", "wiring", "pico", "--out", str(out), "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["conflicts"] == [] and out.read_text("utf-8").startswith("<svg")
    pins = {wire["use"]: wire["pin"] for wire in said["pins"]}
    assert pins["pump_gate"] == 21 and pins["vent_gate"] == 22 and pins["supply_adc"] == 34
    shunts = {wire["use"]: wire["shunt"] for wire in said["pins"]}
    assert shunts["pump_gate"] == "8.2 kΩ" and shunts["estop_sense"] == "30 kΩ, 47 nF"
    assert all(len(part["alternatives"]) == 2 for part in said["parts"])
    assert {"name", "value", "unit"} <= set(said["margins"][0])
    assert main(["bench", "wiring", "pico", "--out", str(out)]) == 2
    assert re.search("already exists", capsys.readouterr().err)
    assert main(["bench", "wiring", "arduino"]) == 2
