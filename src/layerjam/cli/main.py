"""Entry point: every declared command, and one plain sentence for every error."""

import contextlib
import glob
import os
import sys
from collections.abc import Sequence
from typing import Any

import click

from layerjam._version import __version__
from layerjam.cli import TYPED
from layerjam.cli.completion import COMPLETION
from layerjam.core.command.index import GROUPS, HIDDEN, Entry, commands, family_names, find_entry
from layerjam.core.conversion import FACTORS
from layerjam.core.errors import LayerjamError, UnknownNameError
from layerjam.core.store import Appearing
from layerjam.core.system import is_reader_gone, is_windows

MOST_USED = (
    *("new", "show", "force", "vacuum", "tensile", "drop", "tune"),
    *("friction", "pull", "calibrate", "validate", "report"),
    *("design", "build", "workbench"),
)
"""Commands of the short list."""
HELP_OF_ALL = ("help", "all")
HELP = {"help_option_names": ["-h", "--help"]}


class Commands(click.Group):
    """The declared commands, listed from their source and built only when used."""

    first = ""
    """First word of the commands of a family, or ""."""

    def list_commands(self, ctx: Any) -> list[str]:
        """Return the possible next words: names, by group and then most used first."""
        head = f"{self.first} " if self.first else ""
        names = (name.removeprefix(head) for name in self._list_next_words())
        return list(dict.fromkeys(name.split()[0] for name in names))

    def _list_next_words(self) -> tuple[str, ...]:
        return family_names(self.first) if self.first else tuple(commands())

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Return one command, a group of all commands that begin with a word, or None."""
        entry = self._find_command(cmd_name)
        if entry is not None:
            return _build_command(entry.name)
        return _build_family(cmd_name) if not self.first and family_names(cmd_name) else None

    def _find_command(self, word: str) -> Entry | None:
        return find_entry(f"{self.first} {word}".lstrip())

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Return the typed words; a family needs a second word."""
        if self.first and not args:
            words = (f"layerjam {name}" for name in self._list_next_words())
            raise LayerjamError(f"{self.first} is incomplete; type {' or '.join(words)}")
        return super().parse_args(ctx, args)

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return the typed command; for an unknown one raise an error with the nearest names."""
        two_words = " ".join(args[:2])
        if two_words in family_names(args[0]) and self._find_command(args[0]) is not None:
            # a command that also begins the names of others, as in `design new`
            return two_words, _build_command(two_words), args[2:]
        entry = self._find_command(args[0])
        if entry is None:
            if args[0].startswith("-"):
                return super().resolve_command(ctx, args)
            if not self.first and family_names(args[0]):
                return args[0], _build_family(args[0]), args[1:]
            raise UnknownNameError(
                "command", f"{self.first} {args[0]}".lstrip(), self._list_next_words()
            )
        word = entry.name.split()[-1]
        if word != args[0]:
            print(f"layerjam: {args[0]} is now called {entry.name}", file=sys.stderr)
        return word, _build_command(entry.name), args[1:]

    def format_help(self, ctx: Any, formatter: Any) -> None:
        """Write the groups with their commands, and examples for each."""
        self.format_usage(ctx, formatter)
        self.format_help_text(ctx, formatter)
        every = self.first or TYPED.get() == HELP_OF_ALL
        names = [name for name in self._list_next_words() if name not in HIDDEN]
        entries = [commands()[name] for name in names if every or name in MOST_USED]
        width = max(len(entry.name) for entry in entries) + 2
        for group, title in GROUPS.items():
            members = [entry for entry in entries if entry.group == group]
            if members:
                with formatter.section(title):
                    _list_commands(formatter, members, width)
        words = f"layerjam {self.first}".rstrip()
        hidden_count = len(names) - len(entries)
        other_options = (
            f" layerjam help all lists the other {hidden_count} commands." if hidden_count else ""
        )
        formatter.write_paragraph()
        formatter.write_text(f"{words} COMMAND --help explains a command.{other_options}")


def _list_commands(formatter: Any, members: Sequence[Entry], wide: int) -> None:
    rows = [(entry.name.ljust(wide), entry.summary.rstrip(".")) for entry in members]
    formatter.write_dl(rows)
    for entry in members[:2]:
        for example in entry.examples[:1]:
            formatter.write(f"{'':>{formatter.current_indent}}$ {example}\n")


def _build_family(word: str) -> Commands:
    """Return the commands that begin with a word, as a separate group."""
    kind = type("Family", (Commands,), {"first": word})
    return kind(word, help="Choose one of the commands below.", context_settings=HELP)


def _build_command(name: str) -> Any:
    from layerjam.cli.generate import build_command  # it loads brakes and units

    return build_command(name)


def _print_version(ctx: click.Context, option: click.Parameter, value: bool) -> None:
    if value:
        print(f"layerjam {__version__}")
        if "--verbose" in TYPED.get():
            from layerjam.brake.kernel.engine import describe_engine

            print(f"engine  {describe_engine()}")
        ctx.exit()


_VERSION = click.Option(
    ["--version"], is_flag=True, is_eager=True, expose_value=False, callback=_print_version,
    help="Print the version.",
)  # fmt: skip
_VERBOSE = click.Option(
    ["--verbose"], is_flag=True, expose_value=False, help="With --version: the engine of pulls too."
)
app = Commands(
    "layerjam",
    params=[_VERSION, _VERBOSE, *COMPLETION],
    help="Soft layer-jamming brakes: predict, test, calibrate, drive, design and build them.",
    context_settings=HELP,
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command and return its exit code.

    The codes are 0 for a result, 1 for a negative result, 2 for invalid input, 3 if some inputs
    were rejected, 4 if a check failed.
    """
    words = tuple(_expand_patterns(sys.argv[1:]) if arguments is None else arguments)
    before = TYPED.set(words)
    try:
        return _run_command_line(_normalise_help(words))
    finally:
        TYPED.reset(before)
        if arguments is not None:  # otherwise the program ends now
            Appearing.reset()


def _normalise_help(words: tuple[str, ...]) -> tuple[str, ...]:
    """Return the words, with `--help` for `help [COMMAND]` or if there are none."""
    if not words or words == HELP_OF_ALL:
        return ("--help",)
    return (*words[1:], "--help") if words[0] == "help" else words


def _expand_patterns(words: Sequence[str]) -> list[str]:
    """Return the words of the command line; on Windows, expand patterns such as pull-*.csv."""
    if not is_windows():
        return list(words)
    matches = [sorted(glob.glob(word)) if glob.has_magic(word) else [] for word in words]
    return [file for word, files in zip(words, matches, strict=True) for file in files or [word]]


def _run_command_line(words: Sequence[str]) -> int:
    try:
        if sys.stdout is not None and hasattr(sys.stdout, "reconfigure"):
            # a terminal that cannot show µ gets a replacement character
            sys.stdout.reconfigure(errors="replace")
        if "_LAYERJAM_COMPLETE" in os.environ:  # set by the shell's script for completion
            app.main(list(words), "layerjam")
        with app.make_context("layerjam", list(words)) as context:
            code = app.invoke(context)
        if sys.stdout is not None:
            sys.stdout.flush()
        if code == 130:  # the result of a sweep was already printed
            return _print_error("stopped", 130)
        return int(code or 0)
    except click.exceptions.Exit as stop:
        return stop.exit_code
    except KeyboardInterrupt:
        return _print_error("stopped", 130)
    except click.ClickException as error:
        from layerjam.cli.generate import describe_missing

        message = describe_missing(error) or error.format_message()
        return _print_error(_explain_split_quantity(" ".join(message.split()), words), 2)
    except LayerjamError as error:
        return _print_error(" ".join(str(error).split()), 2)
    except OSError as error:  # standard output is full or closed; files have their own errors
        with contextlib.suppress(OSError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        if is_reader_gone(error):
            return 0
        return _print_error(f"the result could not be printed: {error.strerror or error}", 2)
    except (MemoryError, RecursionError):
        return _print_error("the input is too large for this machine's memory", 2)


def _explain_split_quantity(message: str, words: Sequence[str]) -> str:
    """Return the message about an extra word, with the remedy if it is the unit of a number."""
    for option, number, unit in zip(words, words[1:], words[2:], strict=False):
        typed = option.startswith("-") and number.replace(".", "", 1).isdigit()
        if typed and any(unit in units for units in FACTORS.values()):
            remedy = f'{option} {number}{unit} or {option} "{number} {unit}"'
            return f"{option} {number} {unit}: write the number and unit as one word: {remedy}"
    return message


def _print_error(sentence: str, code: int) -> int:
    printable = "".join(c if c.isprintable() else "?" for c in sentence)
    print(f"layerjam: {printable}", file=sys.stderr)
    return code


def run() -> None:
    """Run the program as a console script."""
    sys.exit(main())


if __name__ == "__main__":
    run()
