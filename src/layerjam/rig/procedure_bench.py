"""A bench that carries out procedures and records them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from layerjam.rig.address import Address
from layerjam.rig.crosshead import Crosshead
from layerjam.rig.driver import Bench, opened
from layerjam.rig.execute import Executed, execute
from layerjam.rig.recorder import Block
from layerjam.rig.shots import DropRig
from layerjam.rig.stop import Stop
from layerjam.simulate.procedure import Procedure


class ProcedureBench(Bench):
    """A bench with `run`; what `layerjam.rig.open` gives."""

    def run(
        self,
        procedure: Procedure | str,
        *,
        out: str | Path,
        crosshead: Crosshead | None = None,
        meta: Mapping[str, object] | None = None,
        force: bool = False,
        stop: Stop | None = None,
        watch: Callable[[Block], None] = lambda block: None,
        rig: DropRig | None = None,
        say: Callable[[str], None] = lambda sentence: None,
    ) -> Executed:
        """Carry out a procedure and record it in the file `out`; see `rig.execute.execute`.

        Regulator, safe state and vent rest must be set before.
        """
        return execute(
            self,
            procedure,
            out=out,
            crosshead=crosshead,
            meta=meta,
            force=force,
            stop=stop,
            watch=watch,
            rig=rig,
            say=say,
        )


def open_procedure_bench(address: str | Address) -> ProcedureBench:
    """The bench at an address; see `layerjam.rig.driver.open_bench`."""
    return opened(address, ProcedureBench)
