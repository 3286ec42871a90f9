"""The documents as a site that can be searched: see `scripts/site`."""

import re
from typing import Any

project = html_title = "lienumba"
extensions = ["myst_nb"]
root_doc = "README"
html_theme = "furo"
html_show_copyright = html_show_sphinx = html_copy_source = False
myst_heading_anchors = 4
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 300
suppress_warnings = ["misc.highlighting_failure"]  # Pygments knows no CSV
CONTENTS = re.compile(r"\]\((?:\.\./)?([\w./]+)\.(?:md|ipynb)\)")


def setup(app: Any) -> None:
    app.connect("source-read", add_contents)


def add_contents(app: Any, page: str, source: list[str]) -> None:
    """The contents beside the pages: sections and links of docs/README.md, and all decisions below theirs."""
    if page == "docs/decisions/README":
        source[0] += contents("Decisions", ["[0-9]*"])
    if page == root_doc:
        text = (app.srcdir / "docs" / "README.md").read_text(encoding="utf-8")
        source[0] += contents("Documentation", ["docs/README"])
        for section in text.split("\n## ")[1:]:
            links = dict.fromkeys(CONTENTS.findall(section))
            pages = [x if (app.srcdir / f"{x}.md").exists() else f"docs/{x}" for x in links]
            source[0] += contents(section.partition("\n")[0], pages)


def contents(caption: str, pages: list[str]) -> str:
    return "\n".join(["", "", "```{toctree}", ":hidden:", ":glob:", f":caption: {caption}", "", *pages, "```", ""])
