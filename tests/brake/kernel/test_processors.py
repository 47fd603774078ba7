"""The same bits on x86-64, AArch64 and a Cortex-M4, and nothing that a sanitizer finds."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

from counts import cases
from layerjam.brake.kernel.compiler import FLAGS, SOURCES

HERE = Path(__file__).parent
KERNEL = SOURCES / "layerjam.c"
M4 = ("arm-none-eabi-gcc", "-mcpu=cortex-m4", "-mthumb", "-mfpu=fpv4-sp-d16", "-mfloat-abi=hard")
M4 += ("--specs=rdimon.specs", "-Wl,--section-start=.vectors=0", str(HERE / "cortex_m4.c"))
MACHINE = ("qemu-system-arm", "-M", "mps2-an386", "-nographic", "-monitor", "none", "-serial")
MACHINE += ("null", "-semihosting-config", "enable=on,target=native", "-kernel")
TARGETS = {
    "AArch64": (("aarch64-linux-gnu-gcc", "-static"), ("qemu-aarch64",)),
    "Cortex-M4": (M4, MACHINE),
}
pytestmark = pytest.mark.slow


def built(folder: Path, compiler: tuple[str, ...], source: Path, *more: str) -> Path:
    target = folder / source.stem
    command = [*compiler, *FLAGS, *more, f"-I{SOURCES}", str(source), str(KERNEL), "-lm"]
    done = subprocess.run(
        [*command, "-o", str(target)], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return target


def said(*command: object) -> str:
    done = subprocess.run(
        [*map(str, command)], capture_output=True, text=True, timeout=300, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.parametrize("precision", ["-ULJ_SINGLE", "-DLJ_SINGLE"])
@pytest.mark.parametrize("target", TARGETS)
def test_every_bit_of_every_state_is_the_same(tmp_path, target, precision):
    """4,000 moves with a changing vacuum; after every move all bytes of the state are counted."""
    compiler, emulator = TARGETS[target]
    for tool in ("gcc", compiler[0], emulator[0]):
        if shutil.which(tool) is None:
            pytest.skip(f"{tool} is not installed; make interop installs it")
    here, there = tmp_path / "here", tmp_path / "there"
    here.mkdir()
    there.mkdir()
    own = said(built(here, ("gcc",), HERE / "vector.c", precision))
    other = said(*emulator, built(there, compiler, HERE / "vector.c", precision))
    assert own == other
    assert len(own.splitlines()) == 6


@pytest.mark.parametrize("precision", ["-ULJ_SINGLE", "-DLJ_SINGLE"])
def test_no_input_breaks_it(tmp_path, precision):
    """Millions of moves of random brakes, numbers that are none among them."""
    if shutil.which("gcc") is None:
        pytest.skip("gcc is not installed")
    checks = ("-g", "-D_POSIX_C_SOURCE=200112L", "-fsanitize=address,undefined")
    checks += ("-fno-sanitize-recover=all", precision)
    program = built(tmp_path, ("gcc",), HERE / "fuzz.c", *checks)
    for seed in range(cases(4, 2)):
        words = said(program, 1000, 2000, seed).split()
        counts = {name: int(number) for name, number in zip(words[::2], words[1::2], strict=True)}
        assert min(counts.values()) > 0, f"every corner was visited: {counts}"
