"""Splits printed commands into words, by the rules of the system that they were printed for."""

from __future__ import annotations

import os
import shlex


def split_command(line: str) -> list[str]:
    """The words of a printed command, as a shell of this system passes them on."""
    return split_as_microsoft_c(line.rstrip("\n")) if os.name == "nt" else shlex.split(line)


def split_as_microsoft_c(line: str) -> list[str]:
    """Split a line by the rules of Microsoft's "Parsing C command-line arguments"."""
    words, word, quoted, begun, place = [], "", False, False, 0
    while place < len(line):
        slashes = len(line[place:]) - len(line[place:].lstrip("\\"))
        place += slashes
        mark = line[place : place + 1]
        if mark == '"':
            word += "\\" * (slashes // 2)
            if slashes % 2:
                word += '"'
            else:
                quoted = not quoted
            begun = True
        else:
            word += "\\" * slashes
            begun |= bool(slashes)
            if mark in (" ", "\t", "") and not quoted:
                if begun:
                    words.append(word)
                word, begun = "", False
            else:
                word, begun = word + mark, True
        place += 1
    return [*words, word] if begun else words
