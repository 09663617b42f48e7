#!/usr/bin/env python3
"""Datagrams of the direct link by another implementation than CoSiVA's (docs/protocols/v2x.md), one a line:
kind, session, sequence number, manufacturer, serial number, payload and datagram, the last two in hexadecimal digits."""
import hashlib
import hmac
import struct

KEY = bytes(range(32))


def datagram(kind, session, sequence, manufacturer, serial, payload, key=KEY):
    head = struct.pack(">4sBBQQBBH", b"CV2X", 1, kind, session, sequence, len(manufacturer), len(serial), len(payload))
    body = head + manufacturer + serial + payload
    return body + hmac.new(key, body, hashlib.sha256).digest()


if __name__ == "__main__":
    for kind, session, sequence, serial, payload in (
        (0, 1, 1, b"AIV1", b"{}"),
        (1, 1689033600000000000, 2, b"AIV12", b'{"headerId":7,"mapId":"lacet4"}'),
        (255, 2**64 - 1, 2**64 - 1, b"x", bytes(range(256))),
        (0, 0, 1, b"a" * 64, b""),
        (1, 3, 4, b"AIV1", b"y" * 8000),
    ):
        made = datagram(kind, session, sequence, b"CoSiVA", serial, payload)
        print(kind, session, sequence, "CoSiVA", serial.decode(), payload.hex() or "-", made.hex())
