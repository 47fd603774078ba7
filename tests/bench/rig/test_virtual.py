"""The virtual board: the firmware in a process of its own, a plant behind it, a line before it."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Iterator
from functools import partial
from importlib.util import find_spec

import pytest
from scipy.integrate import solve_ivp

from bench.rig.boards import law_words
from layerjam.bench.control.faults import FaultInjection
from layerjam.bench.control.plant import Plant
from layerjam.bench.control.settings import Regulator
from layerjam.bench.rig.address import Address, address_of
from layerjam.bench.rig.board import VirtualBoard, connect, interpreter_command
from layerjam.bench.rig.line import ChildEnds, Line, LineError
from layerjam.bench.rig.virtual_plant import Hardware, VirtualPlant, read_hardware
from layerjam.brake.fluid.line import Sensor
from layerjam.core.errors import LayerjamError
from layerjam.core.system import is_windows

ONES = ["cpython"] + (["micropython"] if "micropython" in interpreter_command()[0] else [])


@pytest.fixture(params=ONES)
def board(request: pytest.FixtureRequest) -> Iterator[VirtualBoard]:
    line, made = connect(f"sim:choi2018?speed=0&python={request.param}&noise=20 Pa&vent=0.2s")
    assert made is not None
    yield made
    line.close()


def tell(board: VirtualBoard, text: str) -> str:
    said = board.line.ask(1, text.encode()).decode()
    error = board.line.ask(1, b"SYST:ERR?").decode()
    assert error == '0,"No error"', (text, error)
    return said


def ready(board: VirtualBoard, target: float) -> Regulator:
    made = Regulator(
        plant=board.plant.behind.plant, sensor=board.plant.behind.sensor, safe_state="release"
    )
    tell(board, "OUTP:SAFE REL;VENT:REST OPEN;:SYST:LEAS 600")
    tell(board, "CONT:LAW " + law_words(made))
    tell(board, f"VAC {target};:OUTP ON")
    return made


def wait(board: VirtualBoard, seconds: float) -> None:
    """So many seconds of the board's time."""
    end = board.plant.time + seconds
    while board.plant.time < end:
        tell(board, "*OPC?")


def test_it_regulates_releases_and_names_what_breaks(board: VirtualBoard) -> None:
    """Beyond a wrap of its clock, which begins five seconds before one."""
    assert "virtual bench" in tell(board, "*IDN?") and tell(board, "*TST?") == "0"
    made = ready(board, 60e3)
    wait(board, 16)
    # without a leak an excess stays that does not yet open the vent
    assert board.plant.vacuum == pytest.approx(60e3, abs=made.vent_threshold)
    seq, vacuum, target, _pump, vent, state, fault = tell(board, "FETC:ALL?").split(",")
    assert (target, vent, state, fault) == ("60000", "0", "RUN", "0")
    assert float(vacuum) == pytest.approx(60e3, abs=made.vent_threshold + 100) and int(seq) > 1600
    tell(board, "VAC 0")
    wait(board, 3)
    assert board.plant.vacuum < 50 and board.plant.outputs == (0.0, True)
    tell(board, "VAC 80 kPa")
    wait(board, 1)
    board.plant.injected = FaultInjection(pump=0.0)
    end = board.plant.time + 3
    while board.plant.time < end:
        board.line.ask(1, b"*OPC?")
    assert board.line.ask(1, b"OUTP:PROT:FAUL?") in (b'5,"NO_VACUUM"', b'6,"WEAK_PUMP"')
    assert board.plant.outputs == (0.0, True)


def test_a_silent_host_loses_the_outputs(board: VirtualBoard) -> None:
    ready(board, 60e3)
    wait(board, 5)
    tell(board, "SYST:LEAS 3")
    board.plant.trace = []
    begin = board.plant.time
    while board.plant.time < begin + 10:
        time.sleep(0.01)
    when, pump, vent, _ = next(row for row in board.plant.trace if row[2])
    assert (pump, vent) == (0.0, True) and when - begin < 3.0 + 0.05 + 0.5
    assert b"LEASE_EXPIRED" in board.line.ask(1, b"SYST:ERR?")


def test_a_reset_is_another_boot_and_settings_stay(board: VirtualBoard) -> None:
    before = tell(board, "SYST:BOOT?").split(",")
    tell(board, "OUTP:SAFE HOLD;VENT:REST CLOS")
    tell(board, "SYST:SETT:STOR")
    # answered before it comes: a host that hears nothing asks again, and each would reset anew
    assert board.line.ask(1, b"SYST:RES", tries=1) == b""
    end = time.monotonic() + 10
    while (after := tell(board, "SYST:BOOT?").split(","))[0] == before[0]:
        assert time.monotonic() < end
        time.sleep(0.01)
    assert after[1] == '"SOFT"'
    assert tell(board, "OUTP:SAFE?;VENT:REST?") == "HOLD;CLOS"


def test_a_board_goes_with_its_host(board: VirtualBoard) -> None:
    pid = board.pid
    board.close()
    board.close()
    with pytest.raises(OSError if is_windows() else ProcessLookupError):
        os.kill(pid, 0)


def plant(**other: object) -> VirtualPlant:
    made = Plant(rate=0.44, top=95e3, leak=0.004, vent=8.0)
    sensor = Sensor(range=103421.0, lag=0.03)
    return VirtualPlant(Hardware("test", made, sensor, True, 1.0, 0, **other))


@pytest.mark.parametrize("pump", [0.0, 0.3, 1.0])
@pytest.mark.parametrize("power", [False, True])
def test_the_plant_against_an_integrator(pump: float, power: bool) -> None:
    """In uneven steps, with the lag of its sensor, against scipy."""
    made = plant()
    made.vacuum, made.shown = 40e3, 35e3
    made.set_outputs(pump, power)

    def slope(_: float, y: list[float]) -> list[float]:
        out = 0.004 + (0.0 if power else 8.0)
        return [0.44 * pump * (95e3 - y[0]) - out * y[0], (y[0] - y[1]) / 0.03]

    steps = [0.01, 0.0099, 0.0001, 0.013, 0.2, 0.01]
    for dt in steps:
        made.advance(dt)
    right = solve_ivp(slope, (0, sum(steps)), [40e3, 35e3], rtol=1e-11, atol=1e-7).y[:, -1]
    assert (made.vacuum, made.shown) == pytest.approx(tuple(right), rel=1e-7)


def test_the_sensor_breaks_as_it_is_told() -> None:
    made = plant()
    made.vacuum = made.shown = 50e3
    assert made.read_sensor() == (50e3, round(1638 + 13108 * (0.5 + 25e3 / 103421)))
    made.injected = FaultInjection(sensor="offset", value=1e3)
    assert made.read_sensor()[0] == 51e3
    made.injected = FaultInjection(sensor="stuck")
    made.shown = 20e3
    assert made.read_sensor()[0] == 51e3
    made.injected = FaultInjection(sensor="rail", value=103421.0)
    assert made.read_sensor() == (103421.0, 14746)
    made.injected = FaultInjection(sensor="nan")
    assert math.isnan(made.read_sensor()[0])


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "address"),
        ("choi2018", "address"),
        ("usb:x", "did you mean"),
        ("sim:", "address"),
        ("sim:nobody", "nobody"),
        ("sim:choi2018?sped=1", "speed"),
        ("sim:choi2018?speed", "speed=value"),
        ("sim:choi2018?speed=-1", "speed"),
        ("sim:choi2018?speed=5000", "1000"),
        ("sim:choi2018?rest=up", "open"),
        ("sim:choi2018?range=100", "unit"),
        ("sim:choi2018?noise=-5Pa", "noise"),
        ("sim:choi2018?seed=x", "seed"),
        ("sim:choi2018?python=ruby", "micropython"),
        ("tcp:localhost", "port"),
        ("tcp:localhost:0", "port"),
        ("tcp:localhost:5025", "the address of a board"),
        ("serial:/dev/nothing-there", "nothing-there" if find_spec("serial") else "[bench]"),
    ],
)
def test_an_address_that_is_none_is_one_sentence(text: str, says: str) -> None:
    with pytest.raises(LayerjamError) as error:
        connect(text)
    assert says in str(error.value) and "\n" not in str(error.value)


def test_an_address_is_what_was_typed() -> None:
    assert str(address_of("sim:choi2018?speed=0&seed=3")) == "sim:choi2018?speed=0&seed=3"
    assert address_of("tcp:[::1]:5025").host_port == ("::1", 5025)
    assert address_of(Address("sim", "choi2018")).simulated
    assert read_hardware(address_of("sim:choi2018")).sensor.range == 103421.0


@pytest.mark.skipif(is_windows(), reason="Windows' select takes only sockets, not pipes")
def test_a_python_prompt_is_named() -> None:
    heard, said = os.pipe()
    back = os.pipe()
    read, write = partial(os.read, heard), partial(os.write, back[1])
    line = Line(ChildEnds(heard, read, write, lambda: None), "serial:x")
    os.write(said, b"MicroPython v1.25\r\n>>> ")
    with pytest.raises(LineError, match="not running"):
        line.ask(1, b"*IDN?")
    os.close(said)
    with pytest.raises(LineError, match="closed"):
        line.ask(1, b"*IDN?")
    for descriptor in (heard, *back):
        os.close(descriptor)
