"""A publication that an element is named after or taken from; citations print it."""

from typing import NamedTuple


class Reference(NamedTuple):
    """key: by which a text cites it, as [@key]; kind: of BibTeX; venue: its journal, publisher, proceedings or
    institution; numbers: volume(number):pages."""

    key: str
    kind: str
    authors: str
    year: int
    title: str
    venue: str
    numbers: str = ""
    doi: str = ""
