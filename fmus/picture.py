"""The icon of an FMU as a PNG file: a block with its name, a mark for each input on the left and for each output on the right.

Drawn pixel by pixel, so that building an FMU needs no library for pictures and the same component gives the same bytes.
Source of the format: Portable Network Graphics (ISO/IEC 15948), section 5.
"""

from __future__ import annotations

import re
import struct
import zlib

import numpy as np

SIZE, EDGE, BLOCK = 200, 2, (30, 40)  # px: the picture; its lines; distance of the block from the sides and from top and bottom
LARGEST_SCALE = 3  # px of a dot of a letter
MOST_MARKS = 12  # of one side; more signals are shown as so many
PALETTE = ((255, 255, 255), (238, 243, 248), (32, 48, 64), (31, 119, 180), (214, 110, 20))
WHITE, PAPER, INK, IN, OUT = range(5)
LETTERS = {  # the usual matrix of 5 by 8 dots, a byte a column, the lowest bit on top
    "A": "7c1211127c",
    "B": "7f49494936",
    "C": "3e41414122",
    "D": "7f4141413e",
    "E": "7f49494941",
    "F": "7f09090901",
    "G": "3e41415173",
    "H": "7f0808087f",
    "I": "00417f4100",
    "J": "2040413f01",
    "K": "7f08142241",
    "L": "7f40404040",
    "M": "7f021c027f",
    "N": "7f0408107f",
    "O": "3e4141413e",
    "P": "7f09090906",
    "Q": "3e4151215e",
    "R": "7f09192946",
    "S": "2649494932",
    "T": "03017f0103",
    "U": "3f4040403f",
    "V": "1f2040201f",
    "W": "3f4038403f",
    "X": "6314081463",
    "Y": "0304780403",
    "Z": "6159494d43",
    "a": "2054547840",
    "b": "7f28444438",
    "c": "3844444428",
    "d": "384444287f",
    "e": "3854545418",
    "f": "00087e0902",
    "g": "18a4a49c78",
    "h": "7f08040478",
    "i": "00447d4000",
    "j": "2040403d00",
    "k": "7f10284400",
    "l": "00417f4000",
    "m": "7c04780478",
    "n": "7c08040478",
    "o": "3844444438",
    "p": "fc18242418",
    "q": "18242418fc",
    "r": "7c08040408",
    "s": "4854545424",
    "t": "04043f4424",
    "u": "3c4040207c",
    "v": "1c2040201c",
    "w": "3c4030403c",
    "x": "4428102844",
    "y": "4c9090907c",
    "z": "4464544c44",
    "0": "3e5149453e",
    "1": "00427f4000",
    "2": "7249494946",
    "3": "2141494d33",
    "4": "1814127f10",
    "5": "2745454539",
    "6": "3c4a494931",
    "7": "4121110907",
    "8": "3649494936",
    "9": "464949291e",
}


def icon(name: str, inputs: int, outputs: int) -> bytes:
    """PNG of a component with so many inputs and outputs."""
    pixels = np.full((SIZE, SIZE), WHITE, dtype=np.uint8)
    x, y = BLOCK
    pixels[y : SIZE - y, x : SIZE - x] = INK
    pixels[y + EDGE : SIZE - y - EDGE, x + EDGE : SIZE - x - EDGE] = PAPER
    for count, left, colour in ((inputs, x - 14, IN), (outputs, SIZE - x, OUT)):
        for middle in np.linspace(y, SIZE - y, min(count, MOST_MARKS) + 2)[1:-1].astype(int):
            for k in range(5):  # an arrow head, which points to the right
                pixels[middle - k : middle + k + 1, left + 2 * (6 - k) : left + 2 * (7 - k)] = colour
    lines = _lines(name)
    room = SIZE - 2 * x - 12
    scale = max(min(LARGEST_SCALE, room // max(6 * len(line) for line in lines)), 1)
    top = SIZE // 2 - 5 * scale * len(lines)
    for k, line in enumerate(lines):
        dots = _dots(line)[:, : room // scale]
        letters = dots.repeat(scale, axis=0).repeat(scale, axis=1)
        at, start = top + 10 * scale * k + scale, (SIZE - letters.shape[1]) // 2
        pixels[at : at + letters.shape[0], start : start + letters.shape[1]][letters] = INK
    return _png(pixels)


def _lines(name: str) -> list[str]:
    """A name in parts that begin with a capital letter or behind a dash, as many to a line as are no longer than the longest part."""
    parts = re.findall("[A-Z]+[^A-Z_-]*|[^A-Z_-]+", name)
    lines: list[str] = []
    for part in parts:
        if lines and len(lines[-1] + part) <= max(map(len, parts)):
            lines[-1] += part
        else:
            lines.append(part)
    return lines


def _dots(line: str) -> np.ndarray:
    """(8, 6 letters) truth values; letters that the matrix does not have stay blank."""
    columns = [c for letter in line for c in (*bytes.fromhex(LETTERS.get(letter, "00" * 5)), 0)]
    return np.array([[column >> row & 1 for column in columns] for row in range(8)], dtype=bool)


def _png(pixels: np.ndarray) -> bytes:
    """A PNG file of (height, width) places in the palette, two pixels a byte.

    Stored without compression, which differs between versions of zlib: an FMU's token follows from the bytes of its files.
    """
    height, width = pixels.shape
    pairs = pixels[:, ::2] << 4 | pixels[:, 1::2]
    rows = b"".join(b"\0" + row.tobytes() for row in pairs)
    stored = b"\x78\x01\x01" + struct.pack("<HH", len(rows), 0xFFFF - len(rows)) + rows + struct.pack(">I", zlib.adler32(rows))
    header = struct.pack(">IIBBBBB", width, height, 4, 3, 0, 0, 0)
    chunks = {b"IHDR": header, b"PLTE": bytes(c for colour in PALETTE for c in colour), b"IDAT": stored, b"IEND": b""}
    return b"\x89PNG\r\n\x1a\n" + b"".join(_chunk(kind, content) for kind, content in chunks.items())


def _chunk(kind: bytes, content: bytes) -> bytes:
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))
