"""`bench`: real hardware or the virtual board, from the command line."""

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from layerjam.commands.declare import Help, command
from layerjam.commands.results import Result, fact, number, result
from layerjam.rig.outcomes import BenchStatus
from layerjam.units import QuantitySpec

if TYPE_CHECKING:
    from layerjam.rig.serve import Listening

PORT = QuantitySpec("1", "port to listen on; 0 selects a free one", hi=65535, whole=True)
BenchAddress = Annotated[
    str,
    Help(
        "Address of the bench: serial:/dev/ttyACM0, tcp:HOST:PORT, visa:RESOURCE or sim:LINE.",
        metavar="ADDRESS",
    ),
]


@result
class BenchState(Result, BenchStatus):
    """State of a bench at one moment."""


@result
class BenchServed(Result):
    """Result of a gateway after it closed."""

    listening: str = fact("host and port of the server", listed=False)
    pid: int = fact("process ID of the server", listed=False)
    address: str = fact("address of the bench that it served", listed=False)


@command("bench", parent="bench", computes=False)
def bench_status(address: BenchAddress) -> BenchState:
    """Print the state of a bench.

    Sends queries only. Only one client can use the board's serial line; if a gateway is running,
    use its `tcp:` address. Raises FileError, LineError and QuantityError if the bench cannot be
    reached.
    """
    from layerjam.rig.driver import open_bench

    with open_bench(address) as bench:
        return BenchState.of(bench.status())


@result
class BenchCleared(Result):
    """A bench after its fault was cleared."""

    fault: str | None = fact("fault that was cleared; null if there was none")
    state: str = fact("SAFE, RUN, FAULT or DRIVE")
    vacuum: float | None = number("Pa", "last reading")
    simulated: bool = fact("whether the bench is simulated")


@command("bench", parent="bench", computes=False)
def bench_clear(address: BenchAddress) -> BenchCleared:
    """Clear the latched fault of a bench, its error queue and its registers. Nothing starts.

    The bench is in SAFE afterwards. Find the cause first: `bench check` tests the wiring. Raises
    FileError, LineError and QuantityError for a bench that cannot be reached.
    """
    from layerjam.rig.driver import open_bench

    with open_bench(address) as bench:
        fault = bench.fault
        bench.clear()
        state = bench.status()
        return BenchCleared(
            fault=fault, state=state.state, vacuum=state.vacuum, simulated=state.simulated
        )


@command("bench", parent="bench", computes=False)
def bench_serve(
    address: BenchAddress,
    *,
    port: Annotated[int, PORT] = 5025,
    host: Annotated[str, Help("Address to listen on. Other machines need a token.")] = "127.0.0.1",
    token_file: Annotated[
        str | Path | None,
        Help(("File of the token. It is created if it does not exist."), metavar="FILE"),
    ] = None,
    pty: Annotated[
        str | Path | None, Help("Also create a serial port, with this link to it.", metavar="PATH")
    ] = None,
) -> BenchServed:
    """Let many clients talk to one bench, over TCP and as a serial port.

    The first line printed is JSON: `listening`, `pid`, `address`. It runs until SIGTERM or Ctrl-C,
    then switches the outputs off. Raises FileError if the port cannot be opened.
    """
    from layerjam.rig.serve import serve

    results: list[BenchServed] = []

    def announce(server: "Listening") -> None:
        result = BenchServed(
            listening=f"{server.host}:{server.port}", pid=server.pid, address=server.address
        )
        results.append(result)
        keys = {"listening": result.listening, "pid": result.pid, "address": result.address}
        print(json.dumps(keys), flush=True)
        print(f"PyVISA: {server.visa}", file=sys.stderr, flush=True)

    serve(address, announce, port=int(port), host=host, token_file=token_file, pty=pty)
    return results[0]
