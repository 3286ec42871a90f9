"""A small reader of BibTeX, strict about what may go wrong: braces, keys, fields, letters."""

import re

REQUIRED = {
    "article": {"author", "title", "journal", "year"},
    "book": {"author", "title", "publisher", "year"},
    "inproceedings": {"author", "title", "booktitle", "year"},
    "techreport": {"author", "title", "institution", "year"},
    "misc": {"author", "title", "year", "note"},
}  # fmt: skip


def read(text: str) -> dict[str, dict[str, str]]:
    """The fields of each entry by its key."""
    assert text.isascii()
    found: dict[str, dict[str, str]] = {}
    while text := text.strip():
        head = re.match(r"@(\w+)\{(\w+),", text)
        assert head, text[:80]
        end = closing(text, head.end(1))
        assert head[2] not in found, head[2]
        found[head[2]] = fields = _fields(text[head.end() : end])
        assert REQUIRED[head[1]] <= fields.keys(), head[2]
        assert all(fields.values()), head[2]
        text = text[end + 1 :]
    return found


def closing(text: str, start: int) -> int:
    """Where the brace that opens at start closes."""
    depth = 0
    for place in range(start, len(text)):
        depth += {"{": 1, "}": -1}.get(text[place], 0)
        if depth == 0:
            return place
    raise AssertionError(f"a brace does not close: {text[start : start + 60]}")


def _fields(body: str) -> dict[str, str]:
    found: dict[str, str] = {}
    while body := body.strip().lstrip(",").strip():
        name = re.match(r"(\w+) = \{", body)
        assert name, body[:60]
        end = closing(body, name.end() - 1)
        assert name[1] not in found, name[1]
        found[name[1]] = body[name.end() : end]
        assert re.search(r"(?<!\\)[&%#_]", found[name[1]]) is None or name[1] == "doi", found[name[1]]
        body = body[end + 1 :]
    return found
