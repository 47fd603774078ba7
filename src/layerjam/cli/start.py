"""The console script: an interrupt while the program is still loading is no traceback either."""

from __future__ import annotations

import sys


def run() -> None:
    """Load the commands, run one, exit with its code."""
    try:
        from layerjam.cli.main import main

        code = main()
    except KeyboardInterrupt:
        print("layerjam: stopped", file=sys.stderr)
        code = 130
    sys.exit(code)
