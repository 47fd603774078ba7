"""Benches: firmware and serial line of real hardware, their virtual twin, gateway and driver.

`layerjam.bench.rig.open("sim:choi2018")` returns a bench.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from layerjam.bench.rig.address import Address
    from layerjam.bench.rig.execute import ProcedureBench


def open(address: "str | Address") -> "ProcedureBench":
    """Return the bench at an address; see `layerjam.bench.rig.driver.open_bench`."""
    from layerjam.bench.rig.execute import open_procedure_bench

    return open_procedure_bench(address)
