"""The driver, on the board's own line and as a client of a gateway: the same answers."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pytest

import layerjam.bench.rig
from bench.rig.boards import firmware
from bench.rig.gateways import gateway
from layerjam.bench.control.faults import FaultInjection
from layerjam.bench.control.settings import Regulator
from layerjam.bench.rig.address import address_of
from layerjam.bench.rig.driver import Bench, InstrumentError, TrippedError
from layerjam.bench.rig.line import LineError
from layerjam.bench.rig.telemetry import RECORD, read_payload
from layerjam.bench.rig.virtual_plant import read_hardware
from layerjam.core.errors import LayerjamError

FAST = "sim:choi2018?speed=20"


@pytest.fixture(scope="module")
def port() -> Iterator[int]:
    with gateway(FAST) as (number, _):
        yield number


@pytest.fixture(params=["sim", "tcp"])
def bench(request: pytest.FixtureRequest, port: int) -> Iterator[Bench]:
    with layerjam.bench.rig.open(
        FAST if request.param == "sim" else f"tcp:127.0.0.1:{port}"
    ) as made:
        made.clear()
        made.lease = 600.0
        yield made


def regulator() -> Regulator:
    made = read_hardware(address_of(FAST))
    return Regulator(plant=made.plant, sensor=made.sensor, safe_state="release")


def test_a_vacuum_is_held_and_let_go(bench: Bench) -> None:
    bench.safe_state, bench.vent_rest, bench.regulator = "release", "open", regulator()
    bench.target = "40 kPa"
    bench.output = True
    assert bench.wait(10, until=39e3) >= 39e3
    assert (bench.state, bench.target, bench.output) == ("RUN", 40e3, True)
    assert bench.regulator == regulator().pack()
    assert bench.reach == pytest.approx(regulator().plant.reach, rel=1e-8)
    bench.off()
    assert bench.state == "SAFE" and bench.fault is None and bench.events == []


def test_status(bench: Bench) -> None:
    bench.safe_state, bench.vent_rest = "hold", "closed"
    now = bench.status()
    assert now.simulated and now.law_matches and now.double and now.state == "SAFE"
    assert (now.safe_state, now.vent_rest, now.lease, now.fault) == ("hold", "closed", 600.0, None)
    assert now.vent == "closed" and now.uptime >= 0 and len(now.boot) == 8
    assert now.reset_cause == "POWER_ON" and now.errors == ()


def test_what_is_refused_is_raised(bench: Bench) -> None:
    with pytest.raises(InstrumentError, match="FOO") as error:
        bench.ask("FOO?")
    assert error.value.code == -113
    with pytest.raises(InstrumentError) as error:
        bench.lease = 0.1
    assert error.value.code == -222 and "0.2 to 600" in str(error.value)
    with pytest.raises(InstrumentError) as error:
        bench.tell("OUTP:SAFE MAYBE")
    assert error.value.code == -224
    assert bench.ask("*OPC?") == "1"
    for name, value in (("safe_state", "off"), ("vent_rest", "shut"), ("target", "60 s"),
                        ("target", math.nan), ("lease", "1 kPa")):  # fmt: skip
        with pytest.raises(LayerjamError, match=name):
            setattr(bench, name, value)


def test_samples_come_in_order_and_once(bench: Bench) -> None:
    got: list[np.ndarray] = []
    for _ in range(5):
        bench.wait(0.03)
        rows = bench.samples(200)
        got.append(rows["seq"].copy())
        bench.acknowledge(int(rows["seq"][-1]))
    seqs = np.concatenate(got)
    assert np.array_equal(seqs, np.arange(seqs[0], seqs[0] + len(seqs)))
    ring = firmware().ring
    assert RECORD.itemsize == ring.SIZE and ",".join(RECORD.names or ()) == ring.NAMES
    layout, names = bench.ask("STR:FORM?").replace('"', "").split(",", 1)
    assert (layout, names) == (ring.LAYOUT, ring.NAMES)
    with pytest.raises(InstrumentError):
        bench.acknowledge(int(seqs[-1]))


def test_a_fault_ends_a_wait_with_its_name() -> None:
    with layerjam.bench.rig.open(FAST) as bench:
        bench.safe_state, bench.vent_rest, bench.regulator = "release", "open", regulator()
        bench.lease, bench.target, bench.output = 600.0, 60e3, True
        assert bench.plant is not None
        bench.plant.injected = FaultInjection(sensor="nan")
        with pytest.raises(TrippedError) as error:
            bench.wait(10)
        assert error.value.fault == "NOT_A_NUMBER" and bench.fault == "NOT_A_NUMBER"
        assert "NOT_A_NUMBER" in bench.events and math.isnan(bench.vacuum)
        assert bench.plant.outputs == (0.0, True)
        bench.plant.injected = FaultInjection()
        bench.clear()
        assert bench.state == "SAFE"


def test_another_locks(port: int) -> None:
    address = f"tcp:127.0.0.1:{port}"
    with layerjam.bench.rig.open(address) as first, layerjam.bench.rig.open(address) as second:
        assert first.lock() and not second.lock()
        with pytest.raises(InstrumentError) as error:
            second.lease = 5
        assert error.value.code == -203
        second.off()
        first.unlock()
        second.lease = 600


def test_who_only_asks_stops_nobody(port: int) -> None:
    address = f"tcp:127.0.0.1:{port}"
    with layerjam.bench.rig.open(address) as bench:
        bench.clear()
        bench.safe_state, bench.vent_rest, bench.regulator = "release", "open", regulator()
        bench.lease, bench.output = 600.0, True
        with layerjam.bench.rig.open(address) as other:
            assert other.status().state == "RUN"
        assert bench.state == "RUN"
    with layerjam.bench.rig.open(address) as bench:
        assert bench.state == "SAFE"


def test_nobody_there() -> None:
    with pytest.raises(LayerjamError, match="no response"):
        layerjam.bench.rig.open("tcp:127.0.0.1:1")


@pytest.mark.parametrize("block", [b"", b"#", b"#0", b"#15abc", b"#x1a", b"5", b"#13abcd"])
def test_a_torn_block_is_no_data(block: bytes) -> None:
    with pytest.raises(LineError):
        read_payload(block)
