"""The console script: start and end of the program.

Python neither searches modules (JAX, Matplotlib, compiled code) for garbage while they load, nor
unloads them at the end. Together this saves a second.
"""

import atexit
import gc
import os
import sys

SELDOM = (1_000_000, 20, 20)
"""Number of new objects before Python searches for garbage cycles (usually 700).

A long-running server searches more often: `workbench.memory.freeze_modules`.
"""


def run() -> None:
    """Load the commands, run one, exit with its code.

    An interrupt while the program is loading does not print a traceback, nor does a package that
    is not installed.
    """
    gc.set_threshold(*SELDOM)
    codes: list[int] = []
    # the function that is registered first is called last, after all others
    atexit.register(_exit_process, codes)
    try:
        from layerjam.cli.main import main

        code = main()
    except KeyboardInterrupt:
        print("layerjam: stopped", file=sys.stderr)
        code = 130
    except ModuleNotFoundError as error:
        from layerjam.core.installation import install_command

        print(f"layerjam: {error}; install it: {install_command()}", file=sys.stderr)
        code = 2
    codes.append(code)
    sys.exit(code)


def _exit_process(codes: list[int]) -> None:
    """Exit immediately with the code in `codes`; if there is none, let Python end as usual."""
    try:
        for stream in (sys.stdout, sys.stderr):
            if stream is not None:  # Windows programs without a console have no standard streams
                stream.flush()
    except (OSError, ValueError):  # the reader has closed the pipe
        return
    if codes:
        os._exit(codes[0])
