"""An index of the datasets in a folder: what each is of, how its runs ended, and what they show of its requirements."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from lienumba.analysis.text_table import NUMBER, UNIT, WORD, TextTable
from lienumba.batch.statuses import GOOD
from lienumba.errors import ScenarioError
from lienumba.store.files import reading
from lienumba.store.layout import VERDICTS
from lienumba.store.linear_layout import MODES, is_modes
from lienumba.store.outputs import Output, whole
from lienumba.store.study_layout import is_study
from lienumba.words import plural

if TYPE_CHECKING:
    import pandas

ENDING = ".nc"
COLUMNS = ("file", "title", "kind", "runs", "failed", "date", "version", "verdicts")


def index(folder: str | os.PathLike[str], *, recursive: bool = False) -> pandas.DataFrame:
    """The datasets of lienumba in a folder.

    Parameters
    ----------
    folder : path
        Where to look for files whose name ends in ".nc".
    recursive : bool
        Whether also in the folders below it.

    Returns
    -------
    pandas.DataFrame
        A row for each dataset: `file` (relative to the folder), `title`, `kind` ("sweep", "study" or "modes"), `runs`,
        `failed`, `date`, `version`, and `verdicts`, a dict by the names of the requirements. `attrs["skipped"]` has a
        sentence for each file that is no dataset of lienumba.

    Raises
    ------
    ScenarioError
        Where there is no such folder.
    """
    import pandas

    root = Path(folder)
    if not root.is_dir():
        raise ScenarioError(f"{root}: is no folder; give one in which datasets are")
    rows, skipped = [], []
    for path in sorted(root.rglob(f"*{ENDING}") if recursive else root.glob(f"*{ENDING}")):
        try:
            with reading(path, (MODES,)) as (ds, _):
                rows.append({"file": str(path.relative_to(root)), **_row(ds)})
        except ScenarioError as error:
            skipped.append(str(error))
    table = pandas.DataFrame(rows, columns=list(COLUMNS))
    table.attrs["skipped"] = skipped
    return table


def _row(ds: xr.Dataset) -> dict[str, object]:
    status, attributes = ds["status"].values, ds.attrs
    try:
        verdicts = {str(x["requirement"]): str(x["verdict"]) for x in json.loads(attributes.get(VERDICTS, "[]"))}
    except (ValueError, TypeError, KeyError):  # an attribute that somebody else has written
        verdicts = {}
    return {
        "title": str(attributes.get("title", "")),
        "kind": "study" if is_study(ds) else "modes" if is_modes(ds) else "sweep",
        "runs": ds.sizes["run"] if is_modes(ds) else status.size,
        "failed": int(np.count_nonzero(status[:, 0] if is_modes(ds) else ~np.isin(status, GOOD))),
        "date": str(attributes.get("history", "")).partition(" ")[0],
        "version": str(attributes.get("lienumba_version", "")),
        "verdicts": verdicts,
    }


def table(found: pandas.DataFrame) -> TextTable:
    """A row for each dataset."""
    rows = [
        [
            row["file"], row["title"], row["kind"], f"{row['runs']:,}", f"{row['failed']:,}", _said(row["verdicts"]),
            row["date"][:16].replace("T", " "), row["version"],
        ]
        for row in found.to_dict("records")
    ]  # fmt: skip
    headings = ["file", "title", "kind", "runs", "failed", "requirements", "date", "version"]
    return TextTable(headings, [WORD, WORD, WORD, NUMBER, NUMBER, UNIT, WORD, WORD], rows)


def _said(verdicts: dict[str, str]) -> str:
    """How many are met, and which are not."""
    if not verdicts:
        return ""
    rest = [f"{name}: {verdict}" for name, verdict in verdicts.items() if verdict != "met"]
    return ", ".join([f"{len(verdicts) - len(rest)} of {len(verdicts)} met", *rest])


def remarks(skipped: Sequence[str]) -> list[str]:
    """What is said of files that are no datasets."""
    return [f"left out {plural(len(skipped), 'file', 'files')}, the first: {skipped[0]}"] if skipped else []


def save(found: pandas.DataFrame, output: Output) -> None:
    """Write an index as CSV, with a column for each requirement."""
    import pandas

    each = pandas.DataFrame(list(found["verdicts"]), index=found.index) if len(found) else pandas.DataFrame()
    with whole(output) as partial:
        pandas.concat([found.drop(columns="verdicts"), each], axis=1).to_csv(partial, index=False)
