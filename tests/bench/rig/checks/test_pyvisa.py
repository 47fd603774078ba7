"""Checks 3 and 4: PyVISA with its Python backend, over the socket and over the serial port."""

from __future__ import annotations

import time
from collections.abc import Callable

import pytest

pytest.importorskip("pyvisa", reason="PyVISA is not installed: `make bench-checks` has it")

from bench.rig.checks.served import Served
from bench.rig.checks.visa import client, opened, timed

pytestmark = pytest.mark.slow
RECORD = 24


def test_3_a_query_takes_a_millisecond(served: Served, figure: Callable[[str], None]) -> None:
    with client(served) as made:
        times = timed(made, "MEAS:VAC?", 2000)
    median, p99 = times[1000], times[1980]
    figure(
        f" 3  PyVISA socket, 2,000 × MEAS:VAC?: median {median * 1e3:.3f} ms (at most 1), "
        f"p99 {p99 * 1e3:.2f} ms (at most 20)"
    )
    assert median <= 1e-3 and p99 <= 20e-3


def test_4_the_serial_port_with_its_defaults(served: Served, figure: Callable[[str], None]) -> None:
    """200 blocks of the ring of samples; each must hold whole records, in order.

    PyVISA's defaults leave the LF behind a block in which a byte is LF, so blocks need the
    termination said, on a serial port too.
    """
    with opened(f"ASRL{served.pty}::INSTR") as made:
        assert made.query("*IDN?").count(",") == 3
        times = timed(made, "MEAS:VAC?", 500)
        made.read_termination = "\n"
        made.write(f"STR:ACK {made.query('FETC:ALL?').split(',')[0]}")
        seen: list[int] = []
        for _ in range(200):
            data = made.query_binary_values("FETC:STR? 5", datatype="B", container=bytes)
            assert len(data) % RECORD == 0
            numbers = [
                int.from_bytes(data[at : at + 4], "little") for at in range(0, len(data), RECORD)
            ]
            seen += numbers
            if numbers:
                made.write(f"STR:ACK {numbers[-1]}")
            else:
                time.sleep(0.02)
        assert made.query("SYST:ERR?").startswith("0,")
    assert seen == list(range(seen[0], seen[0] + len(seen))) and len(seen) > 100
    figure(
        f" 4  PyVISA serial port: median {times[250] * 1e3:.3f} ms, "
        f"p99 {times[495] * 1e3:.2f} ms; 200 blocks, {len(seen)} records, none missing"
    )
