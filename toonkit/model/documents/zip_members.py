"""Members of a ZIP archive in memory, none larger than it may be."""

from __future__ import annotations

import io
import zipfile
from xml.etree import ElementTree

from toonkit._validation import ToonkitError, refuse
from toonkit.model.decoding import check_size

MOST_DIRECTORY = 1 << 24
"""Bytes of an archive's list of members, at most: a document has some hundred members."""

MOST_XML = 1 << 24
"""Bytes of an XML member, at most."""

_END, _END_SIZE = b"PK\x05\x06", 22
_LOCATOR, _LOCATOR_SIZE = b"PK\x06\x07", 20


class ZipMembers:
    """
    The members of an archive.

    Parameters
    ----------
    argument : str
        Name of the argument, for messages.
    data : bytes
        The archive.
    name : str
        Of the file, for messages.
    kind : str
        What it is to be, such as "an OpenRaster document".

    Raises
    ------
    ToonkitError
        If it is no archive, damaged, or has too many members.
    """

    def __init__(self, argument: str, data: bytes, name: str, kind: str) -> None:
        self.argument, self.name, self.kind = argument, name, kind
        self._check_directory(data)
        try:
            self._archive = zipfile.ZipFile(io.BytesIO(data))
        except Exception as error:  # a damaged archive raises nearly every type there is
            raise self.damaged(error) from error

    def __contains__(self, member: str) -> bool:
        return member in self._archive.NameToInfo

    def damaged(self, why: object) -> ToonkitError:
        """Return the error for a document that cannot be read; the caller raises it."""
        return refuse(self.argument, f"must be {self.kind}, complete and undamaged", f"{self.name} ({why})")

    def read(self, member: str, limit: float) -> bytes:
        """Return a member of at most so many bytes."""
        info = self._archive.NameToInfo.get(member)
        if info is None:
            raise self.damaged(f"{member} is missing")
        if info.file_size > limit:
            raise refuse(
                self.argument,
                f"must be {self.kind} whose {member} has at most {limit / 2**20:.0f} MiB",
                f"{self.name} with {info.file_size / 2**20:.0f} MiB",
            )
        try:
            return self._archive.read(info)
        except MemoryError:
            raise
        except Exception as error:  # a damaged archive raises nearly every type there is
            raise self.damaged(error) from error

    def read_xml(self, member: str) -> ElementTree.Element:
        """Return the root of an XML member."""
        text = self.read(member, MOST_XML)
        if b"<!ENTITY" in text:  # which can grow without bounds, and is in no such document
            raise self.damaged(f"{member} declares entities")
        try:
            return ElementTree.fromstring(text)
        except (ElementTree.ParseError, ValueError, LookupError) as error:
            raise self.damaged(f"{member}: {error}") from error

    def canvas_shape(self, element: ElementTree.Element, names: tuple[str, str]) -> tuple[int, int]:
        """Return the height and width that an element states as attributes of these names."""
        try:
            height, width = (int(element.get(name, "")) for name in names)
        except ValueError as error:
            raise self.damaged(f"<{element.tag}> without a size") from error
        check_size(self.argument, width, height)
        return height, width

    def _check_directory(self, data: bytes) -> None:
        """Refuse a list of members that would take long to read, before it is read."""
        end = data.rfind(_END, max(0, len(data) - _END_SIZE - 0xFFFF))
        if end < 0 or len(data) < end + _END_SIZE:
            raise self.damaged("its end is missing")
        size = int.from_bytes(data[end + 12 : end + 16], "little")
        if size > MOST_DIRECTORY or data[max(0, end - _LOCATOR_SIZE) : end].startswith(_LOCATOR):
            raise self.damaged("it has too many members")
