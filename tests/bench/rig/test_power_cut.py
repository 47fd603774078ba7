"""Check 22: the power goes at every write to the flash while settings are stored.

MicroPython's own littlefs on a flash in memory that tears the page or the erase it is at: half of
it is done, the rest of a page stays erased, and nothing more is written.
"""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from bench.rig.boards import law_words, regulator
from layerjam.bench.rig.board import interpreter_command, write_firmware

SCRIPT = """
import sys
sys.path.insert(0, sys.argv[1])
import os, vfs, binascii
import store

class Cut(Exception):
    pass

class Flash:
    PAGE, SECTOR = 256, 4096
    def __init__(self, sectors):
        self.data = bytearray(b"\\xff" * (sectors * self.SECTOR))
        self.left = self.done = 0
    def readblocks(self, n, buf, off=0):
        at = n * self.SECTOR + off
        memoryview(buf)[:] = self.data[at : at + len(buf)]
    def one(self):
        self.done += 1
        if self.left == 0:
            return True
        self.left -= 1
        if self.left == 0:
            raise Cut
        return False
    def writeblocks(self, n, buf, off=0):
        at = n * self.SECTOR + off
        for page in range(0, len(buf), self.PAGE):
            part = buf[page : page + self.PAGE]
            if self.left == -1:
                return -5
            try:
                self.one()
            except Cut:
                half = len(part) // 2
                self.put(at + page, part[:half])
                self.left = -1
                return -5
            self.put(at + page, part)
    def put(self, at, part):
        for i in range(len(part)):
            self.data[at + i] &= part[i]
    def ioctl(self, op, arg):
        if op == 4:
            return len(self.data) // self.SECTOR
        if op == 5:
            return self.SECTOR
        if op == 6:
            if self.left == -1:
                return -5
            try:
                self.one()
            except Cut:
                half = self.SECTOR // 2
                self.data[arg * self.SECTOR : arg * self.SECTOR + half] = b"\\xff" * half
                self.left = -1
                return -5
            self.data[arg * self.SECTOR : (arg + 1) * self.SECTOR] = b"\\xff" * self.SECTOR
            return 0

class Hal:
    def load(self, slot):
        try:
            with open("/f/settings%d.bin" % slot, "rb") as file:
                return file.read()
        except OSError as error:
            return None if error.errno == 2 else b""
    def save(self, slot, data):
        with open("/f/settings%d.bin" % slot, "wb") as file:
            file.write(data)

def settings(n):
    made = store.Settings()
    made.safe, made.rest, made.offset, made.gain, made.sensor = 1, 1, 10.0 * n, 1.0, "s%d" % n
    made.law = store.parse_law(binascii.unhexlify(open(sys.argv[1] + '/law.hex').read()))[0]
    return made

def mounted(data):
    flash = Flash(16)
    flash.data[:] = data
    vfs.mount(vfs.VfsLfs2(flash, progsize=256), "/f")
    return flash

hal, first = Hal(), Flash(16)
vfs.VfsLfs2.mkfs(first, progsize=256)
vfs.mount(vfs.VfsLfs2(first, progsize=256), "/f")
generation = 0
for n in range(int(sys.argv[2])):
    base = bytes(first.data)
    vfs.umount("/f")
    cut = 1
    while True:
        flash = mounted(base)
        old = store.load(hal)[0]
        flash.left, flash.done = cut, 0
        fresh = settings(n)
        fresh.generation = generation
        try:
            store.save(hal, fresh)
        except OSError:
            pass
        torn = flash.left == -1
        flash.left = 0
        vfs.umount("/f")
        flash = mounted(bytes(flash.data))
        got, error = store.load(hal)
        if torn:
            again = settings(99)
            again.generation = got.generation
            store.save(hal, again)
            assert store.load(hal)[0].sensor == "s99", "a torn flash takes no settings"
        vfs.umount("/f")
        if not torn:
            print("whole", n, cut - 1, got.sensor, error)
            break
        print("cut", n, cut, old.sensor, got.sensor, error, got.law == fresh.law or not got.sensor)
        cut += 1
    first = mounted(bytes(flash.data))
    generation = got.generation
"""


@pytest.mark.skipif(
    "micropython" not in interpreter_command()[0], reason="MicroPython is not installed"
)
def test_settings_are_the_old_or_the_new_ones(tmp_path: Path) -> None:
    saves = 12
    write_firmware(tmp_path)
    script = tmp_path / "script.py"
    script.write_text(SCRIPT, encoding="utf-8")
    (tmp_path / "law.hex").write_text(law_words(regulator()).split('"')[1], encoding="ascii")
    done = subprocess.run(
        [*interpreter_command(), str(script), str(tmp_path), str(saves)],
        capture_output=True, text=True, timeout=60, check=False,
    )  # fmt: skip
    rows = [line.split() for line in done.stdout.splitlines()]
    assert done.returncode == 0, (done.stdout[-500:], done.stderr[-500:])
    whole = [row for row in rows if row[0] == "whole"]
    assert [row[3] for row in whole] == [f"s{n}" for n in range(saves)]
    assert all(row[4] == "0" and int(row[2]) >= 2 for row in whole)
    cuts = [row[1:] for row in rows if row[0] == "cut"]
    assert len(cuts) == sum(int(row[2]) for row in whole)
    for n, _cut, *rest in cuts:
        old, got = rest[0], rest[1] if len(rest) == 4 else rest[0]
        assert got in (old, f"s{n}")
        assert rest[-1] == "True"
