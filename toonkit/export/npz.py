"""Arrays from .npz files of strangers: each is checked by type and size before it is read, and none is a pickle."""

from __future__ import annotations

import math
import re
import zipfile
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from toonkit._validation import refuse

LONGEST_HEADER = 1024
"""Bytes that describe an array, at most; NumPy needs 118 for the arrays of an analysis."""

PART = 1 << 20
"""Bytes that are unpacked at a time."""

# As NumPy writes it, and nothing else: what a general parser accepts may be nested until the stack overflows.
_HEADER = re.compile(
    rb"\{'descr': '([<>|=][biufUO]\d{0,9})', 'fortran_order': (True|False), "
    rb"'shape': \(((?:\d{1,12}, ?)*\d{0,12},?)\), \} *\n"
)
_KINDS = {
    "b": "bool",
    "i": "integers",
    "u": "integers without sign",
    "f": "floats",
    "uf": "floats, or integers without sign",
    "U": "text",
}
_ENCRYPTED = 0x1


class Arrays:
    """
    The arrays of an open .npz file.

    Parameters
    ----------
    file : binary file
        It can be searched, and stays open.

    Raises
    ------
    Exception
        Of nearly any type, as of all methods, if the file is damaged.
    """

    def __init__(self, file: BinaryIO) -> None:
        self._zip = zipfile.ZipFile(file)
        self._members = {member.filename.removesuffix(".npy"): member for member in self._zip.infolist()}

    @property
    def names(self) -> list[str]:
        """Names of the arrays."""
        return sorted(self._members)

    def read(self, name: str, kind: str, *shape: int | None, most: int = 1) -> NDArray[Any]:
        """
        Read an array.

        Parameters
        ----------
        name : str
            Its name.
        kind : str
            "b", "i", "u", "f" or "U", as in `numpy.dtype.kind`, where "i" takes those of "u", too; or "uf" for either.
        *shape : int or None
            Its shape; a length that is None may be any.
        most : int, optional
            Numbers in it, or characters of a text, at most; those that its shape says count anyway.

        Returns
        -------
        ndarray
            Of its own precision, in this machine's byte order.

        Raises
        ------
        ToonkitError
            If it is missing, of another kind or shape, too large, encrypted, or compressed by an unknown method.
        """
        if name not in self._members:
            raise refuse("it", f"must hold {name}", "none")
        member = self._members[name]
        if member.flag_bits & _ENCRYPTED:
            raise refuse(name, "must not be encrypted", "an encrypted array")
        if member.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
            raise refuse(name, "must be stored or deflated", f"compression {member.compress_type}")
        with self._zip.open(member) as stream:
            dtype, column_first, found = _header(name, stream)
            _check(name, dtype, found, kind, shape, most)
            flat = np.empty(math.prod(found), dtype)
            data = memoryview(flat.view(np.uint8))  # type: ignore[arg-type]  # a buffer, which the stubs do not know
            read = 0
            while read < len(data):
                part = stream.read(min(len(data) - read, PART))
                if not part:
                    raise refuse(name, "must be complete", f"{read} of {len(data)} bytes")
                data[read : read + len(part)] = part
                read += len(part)
            if stream.read(1):  # it also compares the checksum
                raise refuse(name, f"must have {len(data)} bytes", "more")
        _check_bits(name, flat)
        array = flat.reshape(found, order="F" if column_first else "C")
        return array.astype(dtype.newbyteorder("="), order="C", copy=False)


def _header(name: str, stream: Any) -> tuple[np.dtype[Any], bool, tuple[int, ...]]:
    """Return type, order and shape of an array, as they stand before it."""
    start = stream.read(8)
    length_bytes = {b"\x93NUMPY\x01": 2, b"\x93NUMPY\x02": 4, b"\x93NUMPY\x03": 4}.get(start[:7])
    if length_bytes is None:
        raise refuse(name, "must be an array", "something else")
    length = int.from_bytes(stream.read(length_bytes), "little")
    if length > LONGEST_HEADER:
        raise refuse(name, f"must be described in {LONGEST_HEADER} bytes", f"{length}")
    described = _HEADER.fullmatch(stream.read(length))
    if described is None:
        raise refuse(name, "must be an array of plain numbers or text", "something else")
    shape = tuple(int(part) for part in described[3].split(b",") if part.strip())
    try:
        dtype = np.dtype(described[1].decode())
    except TypeError as error:
        raise refuse(name, "must be of a type that NumPy knows", described[1].decode()) from error
    return dtype, described[2] == b"True", shape


def _check(
    name: str,
    dtype: np.dtype[Any],
    found: tuple[int, ...],
    kind: str,
    shape: tuple[int | None, ...],
    most: int,
) -> None:
    if dtype.kind not in ("iu" if kind == "i" else kind) or dtype.itemsize == 0:
        raise refuse(name, f"must be {_KINDS[kind]}", f"{dtype}")
    fits = len(found) == len(shape) and all(
        want is None or have == want for have, want in zip(found, shape, strict=True)
    )
    if not fits:
        wanted = "(" + ", ".join("any" if length is None else str(length) for length in shape) + ")"
        raise refuse(name, f"must have shape {wanted}", found)
    size = math.prod(found)
    known = math.prod(length for length in shape if length is not None) if None not in shape else 0
    characters = dtype.itemsize // 4 if kind == "U" else 1
    if size * characters > max(most, known):
        raise refuse(name, f"must have at most {max(most, known):,} entries", f"{size * characters:,}")
    if kind != "U" and dtype.itemsize > np.dtype(np.float64).itemsize:
        raise refuse(name, "must have at most 64 bits a number", f"{dtype}")


def _check_bits(name: str, flat: NDArray[Any]) -> None:
    """Refuse bytes that are no bool and no character: what NumPy makes of them is not defined."""
    if flat.dtype.kind == "b" and flat.size and flat.view(np.uint8).max() > 1:
        raise refuse(name, "must be True or False", "other bytes")
    if flat.dtype.kind == "U":
        code = flat.view(np.dtype(np.uint32).newbyteorder(flat.dtype.byteorder))
        if (code > 0x10FFFF).any() or ((code >= 0xD800) & (code < 0xE000)).any():
            raise refuse(name, "must be text", "what is none in Unicode")
