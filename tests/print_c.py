"""Print the C files of `brake/kernel/c` again from the Python code that they follow."""

from __future__ import annotations

from c_printers import c_program, formulas, loop_printer
from layerjam.brake.kernel.compiler import LOOPS, SOURCES


def print_files() -> None:
    """Write every printed file; tests compare the stored ones."""
    texts = {SOURCES / name: formulas.format_file(name) for name in formulas.LAWS}
    texts |= {SOURCES / name: loop_printer.format_loops(name) for name in loop_printer.MODULES}
    texts[LOOPS[0]] = c_program.format_loops()
    for path, text in texts.items():
        path.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    print_files()
