"""How fast the C kernel steps here, and how much room it takes on a Cortex-M4.

.venv/bin/python -m benchmarks.kernel
"""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from pathlib import Path

from layerjam.brake.device.load import load
from layerjam.brake.kernel.compiler import FLAGS, SOURCES, find_compiler
from layerjam.brake.kernel.parameters import parameters
from layerjam.interop.source import c_files

PROGRAM = """
#include <stdio.h>
#include <time.h>
#include "brake.h"

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec * 1e9 + (double)t.tv_nsec;
}

/* The least of many short rounds: what else runs on the machine disturbs most rounds, not all. */
int main(void)
{
    enum { CALLS = 1000, TURNS = 6000 };
    double best[3] = {1e9, 1e9, 1e9}, sum = 0;
    int kind, turn, i;
    for (turn = 0; turn < TURNS; turn++)
        for (kind = 0; kind < 3; kind++) {
            lj_state s;
            double start, each;
            lj_start(&s, 0);
            lj_move(&brake, &s, kind == 1 ? 5e-4 : 1e-3, 94500, 0);
            start = now();
            for (i = 1; i <= CALLS; i++) {
                double u = kind == 1 ? 5e-4 + 1e-6 * (i & 1) : 1e-3 + 0.04 / CALLS * i;
                sum += lj_move(&brake, &s, u, kind == 2 ? 94500 - (i & 1) : 94500, 0);
            }
            each = (now() - start) / CALLS;
            best[kind] = each < best[kind] ? each : best[kind];
        }
    printf("pull %.1f ns, stuck %.1f ns, vacuum every call %.1f ns a move (%g)\\n", best[0],
           best[1], best[2], sum);
    return 0;
}
"""
CHIPS = {
    "Cortex-M0+": ("-mcpu=cortex-m0plus",),
    "Cortex-M4F": ("-mcpu=cortex-m4", "-mfpu=fpv4-sp-d16", "-mfloat-abi=hard"),
    "Cortex-M7": ("-mcpu=cortex-m7", "-mfpu=fpv5-d16", "-mfloat-abi=hard"),
}


def main() -> None:
    """Print the table."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        of = parameters(load("choi2018-kapton"))
        for file, text in c_files("choi2018-kapton", of, "double").items():
            (folder / file).write_text(text)
        (folder / "speed.c").write_text("#define _POSIX_C_SOURCE 199309L\n" + PROGRAM)
        sources = [str(folder / "speed.c"), str(folder / "layerjam.c")]
        build = [*find_compiler(), *FLAGS, *sources, "-lm", "-o", str(folder / "speed")]
        subprocess.run(build, check=True)
        subprocess.run([folder / "speed"], check=True)
    if shutil.which("arm-none-eabi-gcc") is None:
        print("sizes: arm-none-eabi-gcc is not installed (Debian: gcc-arm-none-eabi)")
        return
    for chip, flags in CHIPS.items():
        sizes = [size(flags, more) for more in ((), ("-DLJ_SINGLE", "-fno-math-errno"))]
        print(f"{chip}: {sizes[0]:,} bytes in double precision, {sizes[1]:,} in single")


def size(chip: tuple[str, ...], more: tuple[str, ...]) -> int:
    """Bytes of code and constants, -Os; there is no other data."""
    with tempfile.TemporaryDirectory() as name:
        target = Path(name) / "layerjam.o"
        command = ["arm-none-eabi-gcc", *chip, *more, "-mthumb", "-Os", "-std=c99"]
        command += ["-ffreestanding", "-ffp-contract=off", "-c", str(SOURCES / "layerjam.c")]
        subprocess.run([*command, "-o", str(target)], check=True)
        said = subprocess.run(
            ["arm-none-eabi-size", str(target)], capture_output=True, text=True, check=True
        ).stdout
    text, data, bss = map(int, said.splitlines()[1].split()[:3])
    assert data == bss == 0
    return text


if __name__ == "__main__":
    main()
