"""A worker process that answers as it should, but for one request, whose answer a test has forged.

Started in the place of Python, with the standard library alone, as hundreds of starts of a real worker would take minutes.
"""

import os
import struct
import time

HEAD = struct.Struct("=IIQB")  # as in orchestrator/units/channel.py
STEP, UPDATE, GET, READ, CALL, JACOBIAN, STATE, VALUES, NUMBERS, DATA, BYTES = range(11)
OUTPUTS = 2


def read(n: int) -> bytes:
    content = b""
    while len(content) < n:
        if not (part := os.read(0, n - len(content))):
            os._exit(0)
        content += part
    return content


def honest(code: int, name: bytes) -> tuple[int, bytes]:
    if code == CALL:
        return DATA, {b"open": b"\x80", b"work": b"\x80", b"read_texts": b"\x91\xa1x"}.get(name, b"\xc0")
    if code in (READ, JACOBIAN):
        return NUMBERS, struct.pack(f"{1 if code == READ else OUTPUTS}d", *[1.0] * (1 if code == READ else OUTPUTS))
    if code == STATE:
        return BYTES, b"state"
    return VALUES, struct.pack(f"{1 + OUTPUTS}d", float("nan"), *[1.0] * OUTPUTS)


def main() -> None:
    request, number = os.environ["FORGED_REQUEST"].encode(), 0
    with open(os.environ["FORGED_ANSWER"], "rb") as file:
        forged = file.read()
    while True:
        mark, number, length, code = HEAD.unpack(read(HEAD.size))
        content = read(length)
        name = content[2 : 2 + (content[1] & 31)] if code == CALL else str(code).encode()
        code, answer = honest(code, name)
        message = HEAD.pack(mark, number, len(answer), code) + answer
        if name == request:
            kind, rest = forged[:1], forged[1:]
            if kind == b"A":  # an answer: code and content
                message = HEAD.pack(mark, number, len(rest) - 1, rest[0]) + rest[1:]
            elif kind == b"H":  # a head: mark, number, length and code, where -1 is as it should be
                given = struct.unpack("=qqQB", rest)
                message = HEAD.pack(mark if given[0] < 0 else given[0], number if given[1] < 0 else given[1], *given[2:])
            elif kind == b"T":  # so many bytes of the message, and the end
                os.write(1, message[: int(rest)])
                os._exit(0)
            elif kind == b"S":  # after the answer, or without one, nothing is read any more
                os.write(1, message if rest else b"")
                time.sleep(60.0)
            elif kind == b"L":  # the same, and a process that is in no group of this one keeps the pipes open
                if not os.fork():
                    os.setsid()
                    time.sleep(15.0)
                os.write(1, message if rest else b"")
                time.sleep(60.0)
            elif kind == b"B":  # byte by byte
                while message:
                    message = message[os.write(1, message[:1]) :]
                    time.sleep(0.1)
            elif kind == b"D":  # the honest answer so many times
                message *= int(rest)
        while message:
            message = message[os.write(1, message) :]


if __name__ == "__main__":
    main()
