"""Completion of commands and options in a shell: prints its script, or installs it."""

import os
import subprocess
from pathlib import Path
from typing import Any

import click
from click.shell_completion import get_completion_class

from layerjam.core.errors import LayerjamError
from layerjam.core.store import store_file
from layerjam.core.system import is_windows, report_failure

SHELLS = ("bash", "zsh", "fish", "powershell", "pwsh")
_DETECT = "the shell of this session"


def _find_shell(name: str) -> str:
    if name == _DETECT:
        name = "powershell" if is_windows() else Path(os.environ.get("SHELL", "")).name
    if name not in SHELLS:
        raise LayerjamError(f"no completion for the shell {name!r}; name one: {', '.join(SHELLS)}")
    return name


def write_script(program: click.Command, shell: str) -> str:
    """Return the script that a shell reads for completion."""
    kind: Any = get_completion_class(shell.replace("pwsh", "powershell"))
    return str(kind(program, {}, "layerjam", "_LAYERJAM_COMPLETE").source())


def install_script(script: str, shell: str) -> Path:
    """Write the script where the shell reads it at its start, and return the file.

    Raises FileError if a file cannot be written, LayerjamError if PowerShell names no profile.
    """
    home = Path.home()
    if shell == "fish":
        return _write(home / ".config/fish/completions/layerjam.fish", script)
    if shell == "bash":
        file = _write(home / ".bash_completions" / "layerjam.sh", script)
        _add_line(home / ".bashrc", f"source '{file}'")
    elif shell == "zsh":
        file = _write(home / ".zfunc" / "_layerjam", script)
        _add_line(home / ".zshrc", "fpath+=~/.zfunc")
        _add_line(home / ".zshrc", "autoload -Uz compinit && compinit")
    else:
        profile = _find_profile(shell)
        file = _write(profile.with_name("layerjam.ps1"), script)
        _add_line(profile, f". '{file}'")
    return file


def _find_profile(shell: str) -> Path:
    words = [shell, "-NoProfile", "-Command", "echo", "$profile"]
    try:
        answer = subprocess.run(words, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        answer = ""
    if not answer:
        raise LayerjamError(f"{shell} does not name its profile; print the script and add it there")
    return Path(answer)


def _write(path: Path, text: str) -> Path:
    with report_failure(path, "cannot be written"):
        path.parent.mkdir(parents=True, exist_ok=True)
    return store_file(path, text, overwrite=True)


def _add_line(path: Path, line: str) -> None:
    """Append a line to a user's file unless it is there; its other lines are never rewritten."""
    with report_failure(path, "cannot be written"):
        old_text = path.read_text(encoding="utf-8") if path.is_file() else ""
        if line not in old_text.splitlines():
            with path.open("a", encoding="utf-8") as file:
                file.write(f"{line}\n" if old_text[-1:] in ("", "\n") else f"\n{line}\n")


def _print_script(ctx: click.Context, option: Any, name: str | None) -> None:
    if name is not None:
        print(write_script(ctx.command, _find_shell(name)))
        ctx.exit()


def _install(ctx: click.Context, option: Any, name: str | None) -> None:
    if name is not None:
        shell = _find_shell(name)
        file = install_script(write_script(ctx.command, shell), shell)
        print(f"completion for {shell} is written to {file}; it begins in the next terminal")
        ctx.exit()


def _make_option(name: str, act: Any, words: str) -> click.Option:
    return click.Option(
        [name], is_flag=False, flag_value=_DETECT, metavar="SHELL", is_eager=True, callback=act,
        expose_value=False, help=words,
    )  # fmt: skip


COMPLETION = (
    _make_option("--install-completion", _install, "Install completion for a shell."),
    _make_option("--show-completion", _print_script, "Print the completion script of a shell."),
)
