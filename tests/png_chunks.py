"""Chunks of PNG files and color profiles, made for tests."""

import struct
import zlib

import imagecodecs


def chunk(name, content, *, damaged=False):
    """One chunk, its checksum right or wrong."""
    checksum = zlib.crc32(name + content) ^ damaged
    return struct.pack(">I", len(content)) + name + content + struct.pack(">I", checksum)


def gamma(value):
    """Name and content of a gAMA chunk."""
    return b"gAMA", struct.pack(">I", round(value * 100_000))


def linear_profile():
    """Linear light in the primaries of sRGB."""
    corners = (0.64, 0.33, 1, 0.30, 0.60, 1, 0.15, 0.06, 1)
    return imagecodecs.cms_profile("rgb", whitepoint=(0.3127, 0.3290, 1), primaries=corners, gamma=1.0)
