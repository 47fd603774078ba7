"""Mutated catalogue texts: a brake or a LayerjamError, nothing else, and never slow."""

from __future__ import annotations

import os
import random
import time

import pytest

from counts import cases
from layerjam.brake.device.brake import validate
from layerjam.brake.device.brake_file import BrakeFile, updated_text
from layerjam.brake.device.load import catalogue, load, materials
from layerjam.core.errors import LayerjamError
from layerjam.core.toml_files.source import Source

QUICK, SLOW = 1200, cases(20_000, 8000)
TEXTS = [load(name).text for name in catalogue()]
MATERIALS = materials()
PIECES = [
    "[", "]", "{", "}", '"', "'", "=", ".", ",", "\n", "#", '"""', "nan", "inf", "-", "0", "1e999",
    "1e-400", "true", "[film]", "[sheets]", "[[x]]", 'use = "kapton-hn"\n', "use = 1\n", "\\u0000",
    "\\", "\x00", "\ufeff", "ü", "😀", "٣", "value", "value = 1", "kind", "1979-05-27", "0x", "0b1",
    '"1 mm"', '"1 kg"', '"-1 mm"', '"1e300 m"', '"9 m^9"', "rope.stiffness = 1\n", "name = 1\n",
    "99999999999999999999", "   ", "site", "a.b.c = 1\n", "{}", "[]", "made_by = 1\n",
]  # fmt: skip


def mutated(rng: random.Random) -> str:
    text = rng.choice(TEXTS)
    for _ in range(rng.randint(1, 4)):
        i, j = sorted((rng.randrange(len(text) + 1), rng.randrange(len(text) + 1)))
        kind = rng.randrange(8)
        if kind == 0:
            text = text[:i] + text[i + rng.randint(1, 12) :]
        elif kind == 1:
            text = text[:i] + rng.choice(PIECES) + text[i:]
        elif kind == 2:
            text = text[:i] + chr(rng.randrange(0xD7FF)) + text[i + 1 :]
        elif kind == 3:
            lines = text.splitlines(keepends=True)
            del lines[rng.randrange(len(lines)) :: max(1, len(lines))]
            text = "".join(lines) or "x"
        elif kind == 4:
            lines = text.splitlines(keepends=True)
            rng.shuffle(lines)
            text = "".join(lines)
        elif kind == 5:
            text = text[:i] + text[i : i + 40] * 2 + text[i + 40 :]
        elif kind == 6:
            digits = [k for k, c in enumerate(text) if c.isdigit()] or [0]
            k = rng.choice(digits)
            text = text[:k] + rng.choice(["", "0", "-", "e", "9" * 30, ".", " "]) + text[k + 1 :]
        else:
            text = text[:j] if rng.random() < 0.1 else text[:i] + rng.choice(PIECES) + text[i + 3 :]
    return text


def read_all(seed: int, count: int) -> tuple[int, float]:
    """How many of the texts were brakes, and the longest time one took; checks what came out."""
    rng = random.Random(seed)
    read, slowest = 0, 0.0
    for _ in range(count):
        text = mutated(rng)
        begun = time.process_time()
        try:
            file = BrakeFile.read(text, "fuzz.toml")
        except LayerjamError as err:
            assert "fuzz.toml" in str(err) or "material" in str(err)
            assert len(str(err)) < 700
        else:
            read += 1
            validate(file.brake)
            if read % 5 == 0:
                assert BrakeFile.read(file.render("x"), "x").brake == file.brake
                changes = {"scale_factor": (0.5, Source())}
                text = updated_text(file, "y", changes)
                assert BrakeFile.read(text, "y").brake.scale_factor == 0.5
        slowest = max(slowest, time.process_time() - begun)
    return read, slowest


def test_mutated_files():
    read, slowest = read_all(1, int(os.environ.get("LAYERJAM_FUZZ", str(QUICK))))
    assert read > 100 and slowest < 2.0


@pytest.mark.slow
def test_many_mutated_files():
    read, slowest = read_all(2, max(SLOW, int(os.environ.get("LAYERJAM_FUZZ", "0"))))
    assert read > 1000 and slowest < 2.0
