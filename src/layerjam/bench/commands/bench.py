"""`bench`: real hardware or the virtual board, from the command line."""

import json
import sys
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from layerjam.bench.rig.outcomes import BenchStatus, Flashed
from layerjam.core.command.declare import Help, command
from layerjam.core.command.results import Result, fact, number, result
from layerjam.core.errors import FileError
from layerjam.core.system import check_file_name
from layerjam.core.units import QuantitySpec

if TYPE_CHECKING:
    from layerjam.bench.rig.serve import Listening

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
    """Result of a gateway after it has closed."""

    listening: str = fact("host and port of the server", listed=False)
    pid: int = fact("process ID of the server", listed=False)
    address: str = fact("address of the bench that it served", listed=False)


@command("bench", parent="bench")
def bench_status(address: BenchAddress) -> BenchState:
    """Print the state of a bench.

    Only queries are sent. Only one client can use the board's serial line; if a gateway is running,
    use its `tcp:` address. Raises FileError, LineError and QuantityError if the bench cannot be
    reached.
    """
    from layerjam.bench.rig.driver import open_bench

    with open_bench(address) as bench:
        return BenchState.create(bench.status())


@result
class BenchCleared(Result):
    """State of a bench after its fault was cleared."""

    fault: str | None = fact("fault that was cleared; null if there was none")
    state: str = fact("SAFE, RUN, FAULT or DRIVE")
    vacuum: float | None = number("Pa", "last reading")
    simulated: bool = fact("whether the bench is simulated")


@command("bench", parent="bench")
def bench_clear(address: BenchAddress) -> BenchCleared:
    """Clear the latched fault, error queue and registers of a bench; no output is switched on.

    The bench is in SAFE afterwards. Find the cause first: `bench check` tests the wiring. Raises
    FileError, LineError and QuantityError for a bench that cannot be reached.
    """
    from layerjam.bench.rig.driver import open_bench

    with open_bench(address) as bench:
        fault = bench.fault
        bench.clear()
        return BenchCleared.create(bench.status(), fault=fault)


@command("bench", parent="bench")
def bench_serve(
    address: BenchAddress,
    *,
    port: Annotated[int, PORT] = 5025,
    host: Annotated[str, Help("Address to listen on. Remote clients need a token.")] = "127.0.0.1",
    token_file: Annotated[
        str | Path | None,
        Help("Token file, created if it does not exist.", metavar="FILE"),
    ] = None,
    pty: Annotated[
        str | Path | None, Help("Also create a virtual serial port at this link.", metavar="PATH")
    ] = None,
) -> BenchServed:
    """Share one bench among many clients, over TCP and as a serial port.

    The first line printed is JSON: `listening`, `pid`, `address`. The gateway runs until SIGTERM or
    Ctrl-C, then switches the outputs off. Raises FileError if the port cannot be opened.
    """
    from layerjam.bench.rig.serve import serve

    results: list[BenchServed] = []

    def announce_server(server: "Listening") -> None:
        keys: dict[str, Any] = {"listening": f"{server.host}:{server.port}", "pid": server.pid}
        keys["address"] = server.address
        results.append(BenchServed(**keys))
        print(json.dumps(keys), flush=True)
        print(f"PyVISA: {server.visa_resource}", file=sys.stderr, flush=True)

    serve(address, announce_server, port=int(port), host=host, token_file=token_file, pty=pty)
    return results[0]


@result
class BoardWiring(Result):
    """Wiring of a board, with any contradictions."""

    board: str = fact("name of the board")
    pins: Sequence[Any] = fact(
        "for each wire: socket pin, label, purpose, parts and other end", listed=False
    )
    margins: Sequence[Any] = fact(
        "worst cases of the electronics: name, value, unit, allowed minimum and maximum",
        listed=False,
    )
    parts: Sequence[Any] = fact(
        "parts to order, alternatives, data sheet limits and computed values", listed=False
    )
    conflicts: Sequence[str] = fact("contradictions in the wiring; empty if there are none")
    out: str | None = fact("drawing file", default=None)


@command("bench", parent="bench")
def bench_wiring(
    board: Annotated[
        str | Path, Help("TOML file of a board, or pico (built in).", metavar="BOARD.toml")
    ],
    *,
    out: Annotated[
        str | Path | None, Help("Write the drawing to this SVG file.", metavar="FILE")
    ] = None,
) -> BoardWiring:
    """List a board's wires and parts, calculate its worst cases, and draw the circuit.

    Raises FileError for a file that does not describe a board, or that exists; UnknownNameError for
    an unknown board.
    """
    from layerjam.bench.rig.circuit import load_circuit
    from layerjam.bench.rig.electronics import compute_margins, find_conflicts

    circuit = load_circuit(board)
    if out is not None:
        from layerjam.bench.figures.wiring_diagram import draw_wiring

        path, svg = Path(out), draw_wiring(circuit)
        check_file_name(path)
        try:
            with path.open("x", encoding="utf-8") as file:
                file.write(svg)
        except FileExistsError:
            raise FileError(path, "already exists") from None
        except OSError as error:
            raise FileError(path, error.strerror or "cannot be written") from None
    return BoardWiring(
        board=circuit.board,
        pins=[asdict(wire) for wire in circuit.wires],
        margins=[row.fields() for row in compute_margins(circuit)],
        parts=[asdict(part) for part in circuit.parts],
        conflicts=find_conflicts(circuit),
        out=None if out is None else str(out),
    )


@result
class BoardFlashed(Result, Flashed):
    """Image written to a board, and the identity that the board then reports."""

    @property
    def exit_code(self) -> int:
        """Exit code: 1 if different firmware runs, or if the board could not be queried."""
        return 0 if self.verified else 1


@command("bench", parent="bench")
def bench_flash(
    port: Annotated[str, Help("Serial port, or the boot loader's drive.", metavar="PORT")],
    *,
    board: Annotated[str, Help("Board type.", metavar="BOARD")] = "pico",
    image: Annotated[
        str | Path | None, Help("Firmware image built by `make firmware`.", metavar="FILE.uf2")
    ] = None,
    settings: Annotated[
        str | Path | None, Help("Wiring of the board's pins.", metavar="FILE.toml")
    ] = None,
) -> BoardFlashed:
    """Write firmware and wiring to a board.

    An image is written through the board's boot loader. Without one, a board with plain MicroPython
    receives the firmware files. Raises FileError, ImageError, LineError, QuantityError and
    UnknownNameError.
    """
    from layerjam.bench.rig.flash import flash

    record = flash(
        port,
        board=board,
        image=None if image is None else Path(image),
        settings=None if settings is None else Path(settings),
    )
    return BoardFlashed.create(record)
