"""`bench wiring`: the wiring of a board as a list, a check and a drawing."""

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any

from layerjam.commands.declare import Help, command
from layerjam.commands.results import Result, fact, result
from layerjam.errors import FileError
from layerjam.system import check_name


@result
class BoardWiring(Result):
    """Wires of a board, and contradictions between them."""

    board: str = fact("the board")
    pins: Sequence[Any] = fact(
        "for each wire: socket pin, label, purpose, parts and other end",
        listed=False,
    )
    margins: Sequence[Any] = fact(
        ("worst cases of the electronics: name, value, unit, allowed minimum and maximum"),
        listed=False,
    )
    parts: Sequence[Any] = fact(
        "parts to order, alternatives, data sheet limits and computed values", listed=False
    )
    conflicts: Sequence[str] = fact("contradictions in the wiring; empty if there are none")
    out: str | None = fact("file of the drawing", default=None)


@command("bench", parent="bench", computes=False)
def bench_wiring(
    board: Annotated[str | Path, Help("A board's TOML file, or pico.", metavar="BOARD.toml")],
    *,
    out: Annotated[
        str | Path | None, Help("Write the drawing to this SVG file.", metavar="FILE")
    ] = None,
) -> BoardWiring:
    """List a board's wires and parts, calculate the worst cases, and draw the circuit.

    Raises FileError for a file that does not describe a board, or that exists; UnknownNameError for
    an unknown board.
    """
    from layerjam.rig.circuit import load_circuit
    from layerjam.rig.electronics import find_conflicts, margins

    circuit = load_circuit(board)
    if out is not None:
        from layerjam.report.wiring import drawing

        path, svg = Path(out), drawing(circuit)
        check_name(path)
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
        margins=[row.fields() for row in margins(circuit)],
        parts=[asdict(part) for part in circuit.parts],
        conflicts=find_conflicts(circuit),
        out=None if out is None else str(out),
    )
