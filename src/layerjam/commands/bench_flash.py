"""`bench flash`: firmware and wiring onto a board."""

from pathlib import Path
from typing import Annotated

from layerjam.commands.declare import Help, command
from layerjam.commands.results import Result, result
from layerjam.rig.outcomes import Flashed


@result
class BoardFlashed(Result, Flashed):
    """Image written to a board, and the identity that the board then reports."""

    @property
    def exit_code(self) -> int:
        """Exit code: 1 if other firmware runs, or if the board could not be queried."""
        return 0 if self.verified else 1


@command("bench", parent="bench", computes=False)
def bench_flash(
    port: Annotated[str, Help("Serial port, or the boot loader's drive.", metavar="PORT")],
    *,
    board: Annotated[str, Help("Kind of board.", metavar="BOARD")] = "pico",
    image: Annotated[
        str | Path | None, Help("Image that `make firmware` built.", metavar="FILE.uf2")
    ] = None,
    settings: Annotated[
        str | Path | None, Help("Connections of the board's pins.", metavar="FILE.toml")
    ] = None,
) -> BoardFlashed:
    """Put firmware and wiring onto a board.

    An image is written through the board's boot loader. Without one, a board with plain MicroPython
    receives the firmware files. Raises FileError, ImageError, LineError, QuantityError and
    UnknownNameError.
    """
    from layerjam.rig.flash import flash

    record = flash(
        port,
        board=board,
        image=None if image is None else Path(image),
        settings=None if settings is None else Path(settings),
    )
    return BoardFlashed.of(record)
