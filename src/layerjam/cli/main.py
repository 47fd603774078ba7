"""Entry point: every command, and one plain sentence for every error."""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Sequence
from typing import Annotated

import typer
from typer.exceptions import Abort, Exit, TyperException

from layerjam._version import __version__
from layerjam.cli import (
    apply,
    array,
    calibration,
    compare,
    design,
    follow,
    friction,
    impact,
    judder,
    lab,
    measurements,
    paper,
    parts,
    plan,
    predict,
    pull,
    regulate,
    report,
    sweep,
    vacuum_line,
    validation,
    workbench,
)
from layerjam.errors import LayerjamError

app = typer.Typer(
    name="layerjam",
    help="Soft layer-jamming brakes: design, predict, read tests, calibrate, invert.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
for group in (
    predict,
    impact,
    judder,
    lab,
    pull,
    friction,
    calibration,
    validation,
    report,
    measurements,
    vacuum_line,
    parts,
    regulate,
    follow,
    plan,
    compare,
    array,
    design,
    sweep,
    apply,
    workbench,
    paper,
):
    group.register(app)


def _show_version(value: bool) -> None:
    if value:
        print(f"layerjam {__version__}")
        raise Exit(0)


@app.callback()
def _common(
    version: Annotated[
        bool,
        typer.Option("--version", callback=_show_version, is_eager=True, help="Print the version."),
    ] = False,
) -> None:
    pass


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command; returns its exit code: 0 answered, 1 cannot, 2 bad input, 3 partly."""
    try:
        if sys.stdout is not None and hasattr(sys.stdout, "reconfigure"):
            sys.stdout.reconfigure(errors="replace")  # a terminal that knows no µ gets a mark
        code = app(args=arguments, standalone_mode=False)
        if sys.stdout is not None:
            sys.stdout.flush()
        if code == 130:  # typer swallows an interrupt; of a sweep the answer was printed
            return _say("stopped", 130)
        return int(code or 0)
    except Exit as stop:
        return stop.exit_code
    except Abort:
        return _say("stopped", 130)
    except KeyboardInterrupt:
        return _say("stopped; nothing was written", 130)
    except TyperException as error:
        # a bare `layerjam` shows its help, which is no error message
        message = " ".join(error.format_message().split())
        return _say(message or "say what to do: layerjam --help", 2)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except LayerjamError as error:
        return _say(" ".join(str(error).split()), 2)
    except OSError as error:  # standard output is full or closed; files have their own errors
        with contextlib.suppress(OSError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        return _say(f"the answer could not be printed: {error.strerror or error}", 2)
    except (MemoryError, RecursionError):
        return _say("the input is too large for this machine's memory", 2)


def _say(sentence: str, code: int) -> int:
    plain = "".join(c if c.isprintable() else "?" for c in sentence)
    print(f"layerjam: {plain}", file=sys.stderr)
    return code


def run() -> None:
    """Console script."""
    sys.exit(main())


if __name__ == "__main__":
    run()
