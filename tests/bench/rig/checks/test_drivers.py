"""Checks 5 and 6: drivers that PyMeasure, QCoDeS and easy-scpi bring with them."""

from __future__ import annotations

from collections.abc import Callable

import pytest

pytest.importorskip("pyvisa", reason="PyVISA is not installed: `make bench-checks` has it")

from bench.rig.checks.served import Served
from bench.rig.checks.visa import ENDS

pytestmark = [
    pytest.mark.slow,
    # of these libraries and what they are built on, not ours
    pytest.mark.filterwarnings("ignore"),
]


def test_5_pymeasure(served: Served, figure: Callable[[str], None]) -> None:
    instruments = pytest.importorskip("pymeasure.instruments")

    class Bench(instruments.SCPIMixin, instruments.Instrument):  # type: ignore[misc,name-defined]
        pass

    made = Bench(served.resource, "a bench", visa_library="@py", **ENDS)
    assert made.id.startswith("layerjam,")
    assert int(made.status) >= 0
    assert made.options == "0"
    assert int(made.complete) == 1
    made.clear()
    made.reset()
    assert made.check_errors() == []
    made.write("NOBODY:KNOWS")
    assert made.next_error[0] == -113
    made.write("SOUR:VAC MANY")
    assert [int(one[0]) for one in made.check_errors()] == [-104]
    made.adapter.close()
    figure(" 5  PyMeasure SCPIMixin: id, status, options, complete, clear, reset, errors")


def test_6_qcodes(served: Served, figure: Callable[[str], None]) -> None:
    visa = pytest.importorskip("qcodes.instrument.visa")
    made = visa.VisaInstrument(
        "bench", served.resource, terminator="\n", visalib="@py", device_clear=False
    )
    try:
        said = made.get_idn()
        assert said["vendor"] == "layerjam" and said["model"] == "virtual bench"
        made.add_parameter("vacuum", get_cmd="MEAS:VAC?", get_parser=float, unit="Pa")
        assert abs(made.vacuum()) < 2000.0
    finally:
        made.close()
    figure(f" 6  QCoDeS VisaInstrument: {said}")


def test_6_easy_scpi(served: Served, figure: Callable[[str], None]) -> None:
    easy = pytest.importorskip("easy_scpi")
    made = easy.Instrument(served.resource, port_match=False, backend="@py", **ENDS)
    made.connect()
    try:
        assert float(made.source.vacuum()) == 0.0
        assert abs(float(made.measure.vacuum())) < 2000.0
    finally:
        made.disconnect()
    figure(" 6  easy-scpi: source.vacuum(), measure.vacuum()")
