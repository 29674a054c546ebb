"""XML, element by element as it comes, without a tree. Document type declarations, so entities, are refused."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from xml.etree import ElementTree
from xml.parsers import expat

from hognose.errors import InputError

Start = Callable[[str, dict[str, str]], object]
End = Callable[[str], object]


class Stream:
    """A parser whose handlers can be changed while it runs.

    Names of elements and attributes in a namespace come as "namespace name", others as they are.

    Attributes
    ----------
    start, end, text
        Called at the beginning and the end of each element, and for what is between.
    prefixes
        The namespace of each prefix declared so far.
    """

    def __init__(self, start: Start, end: End, text: End | None = None) -> None:
        self.prefixes: dict[str, str] = {}
        self._parser = expat.ParserCreate(namespace_separator=" ")
        self._parser.StartDoctypeDeclHandler = _refuse_doctype
        self._parser.StartNamespaceDeclHandler = self._prefix
        self._parser.CharacterDataHandler = text
        self._parser.buffer_text = True
        self.use(start, end)

    def use(self, start: Start, end: End) -> None:
        """Go on with other handlers."""
        self._parser.StartElementHandler, self._parser.EndElementHandler = start, end

    @property
    def line(self) -> int:
        """The line that is being read."""
        return self._parser.CurrentLineNumber

    def read(self, chunks: Iterable[bytes]) -> None:
        """Read all; raises InputError, and what the handlers raise."""
        try:
            for chunk in chunks:
                self._parser.Parse(chunk, False)
            self._parser.Parse(b"", True)
        except InputError:
            raise
        except expat.ExpatError as error:
            raise InputError(f"cut or damaged: line {error.lineno}: {expat.ErrorString(error.code)}") from None
        except (LookupError, ValueError) as error:  # an encoding that there is not
            raise InputError(f"damaged: {error}") from None

    def _prefix(self, prefix: str | None, uri: str) -> None:
        self.prefixes[prefix or ""] = uri


def _refuse_doctype(*_: object) -> None:
    raise InputError("has a document type declaration (DTD), which is not read; export it again without")


def tree(data: bytes) -> ElementTree.Element:
    """Return the root of an XML file that fits into memory; raises as `Stream.read` does."""
    builder = ElementTree.TreeBuilder()
    Stream(builder.start, builder.end, builder.data).read([data])
    return builder.close()
