"""The files of a system: beside an .ssd file, or inside an .ssp archive. Nothing outside of an archive is ever opened.

An .ssd file may name files of neighbouring folders by "..", as a scene may. What an archive calls its members is used to find
them, never to name a file on this machine: an FMU is copied into the user's cache under the digest of its content.
"""

from __future__ import annotations

import re
import zipfile
import zlib
from copy import copy
from io import BytesIO
from math import isfinite, nan
from pathlib import Path, PurePosixPath
from urllib.parse import unquote, urlsplit

from lxml import etree

from ....components.core.errors import BadInput, nearest
from ....components.core.measure import bare_number
from ....components.core.store import digest_of, kept, replaced
from ...loading import MOST_INSIDE, check_archive

NAMESPACES = {
    letters: f"http://ssp-standard.org/SSP1/SystemStructure{name}"
    for letters, name in (
        ("ssd", "Description"),
        ("ssc", "Common"),
        ("ssv", "ParameterValues"),
        ("ssm", "ParameterMapping"),
        ("ssb", "SignalDictionary"),
    )
}
DEFAULT = "SystemStructure.ssd"
PROXY = "proxyfmu://localhost?file="
LARGEST_TEXT = 1 << 28  # bytes of an XML file, unpacked: far above what systems need, far below what fills a memory


class Package:
    """A folder or a zip archive whose files are asked for by a relative URI, from the place of one of them."""

    def __init__(self, name: str, folder: Path | None = None, archive: zipfile.ZipFile | None = None):
        self.name, self._folder, self._archive = name, folder, archive
        self._base: tuple[str, ...] = ()  # folders down to the document whose URIs are resolved
        self.remarks: list[str] = []  # what was accepted although the standard does not have it

    @classmethod
    def zipped(cls, name: str, content: Path | bytes) -> Package:
        """An archive by its path or its bytes; `BadInput` where it is none."""
        try:
            archive = zipfile.ZipFile(BytesIO(content) if isinstance(content, bytes) else content)
            check_archive(archive, name)
            return cls(name, archive=archive)
        except OSError as error:
            raise BadInput("scene", repr(name), "a file that can be read", f"{error.strerror}.") from None
        except zipfile.BadZipFile as error:
            raise BadInput(name, f"no zip archive ({error})", "an .ssp file") from None

    def close(self) -> None:
        """Let go of the archive's file."""
        if self._archive is not None:
            self._archive.close()

    def beside(self, file: str) -> Package:
        """The same files, with URIs that begin where one of them lies: a document's own are relative to it (RFC 3986, 5.1)."""
        other = copy(self)
        other._base = PurePosixPath(file).parent.parts
        return other

    def label(self, file: str) -> str:
        """What messages call a file of this package."""
        return file if self._archive is None else f"{self.name}/{file}"

    def read(self, path: str, where: str, largest: int | None = None) -> bytes:
        """The content of a file by its path, as of `inside`; `BadInput` for one that is missing, broken or too large."""
        try:
            if self._archive is None:
                assert self._folder is not None
                file = self._folder / path
                size, content = file.stat().st_size, file.read_bytes
            else:
                info = self._archive.getinfo(path)
                size, content = info.file_size, lambda: self._archive.read(info)  # type: ignore[union-attr]
            if largest is not None and size > largest:
                raise BadInput(where, f"{path!r} of {size} bytes", f"at most {largest} bytes")
            return content()
        except KeyError:
            assert self._archive is not None
            raise BadInput(where, f"file {path!r}", f"a file of {self.name}", nearest(path, self._archive.namelist())) from None
        except OSError as error:
            raise BadInput(where, f"file {path!r}", f"a file beside {self.name}", f"{error.strerror or error}.") from None
        except (zipfile.BadZipFile, zlib.error, RuntimeError, EOFError, ValueError) as error:  # a wrong sum, encryption ...
            if isinstance(error, BadInput):
                raise
            raise BadInput(where, f"file {path!r} that cannot be unpacked", "a sound archive", f"{error}.") from None

    def inside(self, uri: str, where: str) -> str:
        """The path of a relative URI in the package; absolute ones are refused, and those that lead out of an archive."""
        try:
            parts = urlsplit(uri)
        except ValueError:  # half a pair of brackets
            parts = urlsplit("//")
        names = [unquote(segment) for segment in parts.path.split("/")]
        unlike = any(set(name) & set("/\\:\0") for name in names) or uri.partition("#")[0].endswith("?")
        if (
            not parts.path
            or parts.path.startswith("/")
            or parts.scheme
            or parts.netloc
            or parts.query
            or parts.fragment
            or unlike
        ):
            raise self._refused(uri, where)
        pieces = list(self._base)
        for name in names:
            if name == ".." and pieces and pieces[-1] != "..":
                pieces.pop()
            elif name == ".." and self._archive is not None:
                raise self._refused(uri, where)
            elif name not in ("", "."):
                pieces.append(name)
        if not pieces or names[-1] in ("", ".", ".."):
            raise self._refused(uri, where)
        if ".." in pieces and self.name.endswith(".ssd"):
            self.remarks.append(f"{where}: source {uri!r} lies outside the folder of {self.name}; an .ssp archive cannot have it")
        return "/".join(pieces)

    def _refused(self, uri: str, where: str) -> BadInput:
        return BadInput(where, f"source {uri!r}", "a relative path to a file inside the package", "Put the file there.")

    def fmu(self, uri: str, where: str) -> Path:
        """The file of an FMU: where it lies in a folder, or its copy in the cache, which is written once for each content."""
        if uri.startswith(PROXY):  # Open Simulation Platform runs it behind a socket; here isolation = "process" does that
            self.remarks.append(f"{where}: source {uri!r} is read as the file itself")
            uri = uri.removeprefix(PROXY)
        path = self.inside(uri, where)
        if self._folder is not None:
            try:
                file = (self._folder / path).resolve()  # the sandbox has the folder of the file, and none on the way to it
                if file.is_file():
                    return file
            except OSError:  # a name that no file can have
                pass
            raise BadInput(where, f"source {uri!r}", f"an FMU file beside {self.name}")
        content = self.read(path, where, MOST_INSIDE)
        stem = re.sub(r"\W", "_", PurePosixPath(path).stem, flags=re.ASCII)[:64]
        return kept("ssp", digest_of(content), f"{stem}.fmu", lambda path: _written(path, content))


def _written(path: Path, content: bytes) -> Path:
    """A file that appears as a whole."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with replaced(path, "wb") as file:
        file.write(content)
    return path


def opened(path: Path) -> tuple[Package, str]:
    """The package of a system's file, and the name of the description in it."""
    if path.suffix == ".ssp":
        return Package.zipped(str(path), path), DEFAULT
    return Package(str(path), folder=path.parent), path.name


def parsed(content: bytes, where: str, remarks: list[str]) -> etree._Element:
    """The root of an XML file; `BadInput` with the line of a fault, and for entities, which may reach for other files.

    Prefixes that the file does not declare get a remark: those of SSP mean what they usually do, others are passed by.
    """
    # undeclared prefixes alone are what this parser may recover from; the first of all other faults is an error
    parser = etree.XMLParser(
        resolve_entities=False, no_network=True, load_dtd=False, remove_comments=True, remove_pis=True, recover=True
    )
    try:
        root = etree.fromstring(content, parser)
    except etree.XMLSyntaxError as error:  # nothing is left
        raise BadInput(_at(where, error.lineno), f"a syntax error: {error.msg}", "an XML file") from None
    undeclared: dict[str, int] = {}
    for entry in parser.error_log:
        if entry.type != etree.ErrorTypes.NS_ERR_UNDEFINED_NAMESPACE:
            raise BadInput(_at(where, entry.line), f"a syntax error: {entry.message}", "an XML file")
        undeclared.setdefault(entry.message.split()[2], entry.line)
    if root is None:
        raise BadInput(where, "a file without elements", "an XML file")
    if root.getroottree().docinfo.internalDTD is not None:
        raise BadInput(where, "a document type with entities of its own", "plain XML")
    for prefix, line in undeclared.items():
        meaning = f"taken as {NAMESPACES[prefix]}" if prefix in NAMESPACES else "its meaning is not known"
        remarks.append(f"{_at(where, line)}: the prefix {prefix!r} is not declared; {meaning}")
    for element in root.iter() if undeclared else ():
        prefix, _, name = element.tag.rpartition(":")
        if prefix in NAMESPACES:
            element.tag = f"{{{NAMESPACES[prefix]}}}{name}"
    return root


def _at(where: str, line: int | None) -> str:
    return f"{where}:{line}" if line else where


def required(element: etree._Element, attribute: str, where: str) -> str:
    """The value of an attribute that must be there and not be empty."""
    value = element.get(attribute)
    if not value:
        name = etree.QName(element).localname
        raise BadInput(f"{where}:{element.sourceline}", f"{name} without {attribute}", f'{attribute}="..."')
    return value


def number(element: etree._Element, attribute: str, default: float, where: str) -> float:
    """The value of a numerical attribute, which must be finite."""
    text = element.get(attribute)
    try:
        value = default if text is None else bare_number(text)
    except ValueError:
        value = nan
    if not isfinite(value):
        raise BadInput(f"{where}:{element.sourceline}", f'{attribute}="{text}"', "a finite number")
    return value


def truth(text: str, what: str, where: str) -> bool:
    """A truth value as XML writes it."""
    if text.strip() not in ("true", "false", "1", "0"):
        raise BadInput(where, f"{what} {text!r}", "true or false")
    return text.strip() in ("true", "1")


def find_all(element: etree._Element, *path: str) -> list[etree._Element]:
    """Children of children ..., each step as "ssd:Name"."""
    return element.findall("/".join(path), NAMESPACES)
