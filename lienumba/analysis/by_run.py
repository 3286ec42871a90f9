"""A sweep as a table with one row for each run: how it ended, its inputs, and the numbers that it has once."""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import xarray as xr

from lienumba.analysis.changed import change_names, tells
from lienumba.analysis.mode_runs import OUTPUTS, as_runs
from lienumba.analysis.outcomes import BY_CODE
from lienumba.analysis.sensitivities.outputs import of_every_run
from lienumba.batch.changes import NONE
from lienumba.errors import ScenarioError
from lienumba.store.layout import RUN, TABLE
from lienumba.store.linear_layout import is_modes
from lienumba.store.outputs import Output, whole
from lienumba.store.study_layout import is_study
from lienumba.store.targets import claimed

if TYPE_CHECKING:
    import pandas

CSV, PARQUET, MATLAB = ".csv", ".parquet", ".mat"
ENDINGS = (CSV, PARQUET, MATLAB)
STARTS = (RUN[0].encode(), b"PAR1", b"MATLAB")  # of a file of each
LONGEST = 63  # names of variables in MATLAB


def run_table(ds: xr.Dataset, output: str | Sequence[str] = (), time: float | None = None) -> pandas.DataFrame:
    """One row for each run, whether it failed or not.

    Parameters
    ----------
    ds : xarray.Dataset
        What `lienumba.run` or `lienumba.modes` returned.
    output : str or sequence of str
        Names such as `tip` or `last_position.top.z`, of modes `frequency.3`; all numbers that a run has once if
        omitted.
    time : float, optional
        A stored time in s at which series are read; the last if omitted.

    Returns
    -------
    pandas.DataFrame
        With the index `run`; the columns `status`, the inputs, and the outputs, in their units, which stand in
        `attrs["units"]` by the names of the columns; kinds of changes and what changed by name. NaN: a run has no such
        number.
    """
    import pandas

    if is_study(ds):
        raise ScenarioError("the dataset is that of a study, which has no runs alone; give one of a sweep")
    output = output or (OUTPUTS if is_modes(ds) else ())
    ds = as_runs(ds)
    inputs = {str(name): x for name, x in ds.coords.items() if x.attrs.get("role") == "input" and x.dims == RUN}
    columns: dict[str, Any] = {"status": [BY_CODE[code] for code in ds["status"].values.tolist()]}
    units = {name: str(x.attrs.get("units", "1")) for name, x in inputs.items()}
    columns |= {name: x.values for name, x in inputs.items()}
    for found in of_every_run(ds, [output] if isinstance(output, str) else output, time):
        columns[found.name], units[found.name] = found.values, found.units
    if tells(ds):
        _name_changes(ds, columns)
    table = pandas.DataFrame(columns, index=pandas.Index(ds[RUN[0]].values, name=RUN[0]))
    table.attrs["units"] = {name: unit for name, unit in units.items() if name in columns}
    return table


def _name_changes(ds: xr.Dataset, columns: dict[str, Any]) -> None:
    """Kinds of changes and what changed by their names, without the columns in which no run has a change."""
    kinds, whats = ds["change_kind"].values, ds["change_what"].values
    for n in range(kinds.shape[1]):
        own = [name for name in (f"{column}.{n}" for column in TABLE) if name in columns]
        for name in own if (kinds[:, n] == NONE).all() else ():
            del columns[name]
        names = [change_names(ds, kind, what) for kind, what in zip(kinds[:, n], whats[:, n], strict=True)]
        for name, of in (("change_kind", 0), ("change_what", 1)):
            if f"{name}.{n}" in columns:
                columns[f"{name}.{n}"] = [found[of] for found in names]


def claimed_table(target: Path, overwrite: bool) -> AbstractContextManager[Output]:
    """Own the file of a table, from before anything is read; refuse one that must not be replaced."""
    return claimed(target, "table of runs", ENDINGS, overwrite, STARTS)


def save(table: pandas.DataFrame, output: Output) -> None:
    """Write a table of runs, by the ending of its name."""
    ending = output.path.suffix.lower()
    with whole(output) as partial:
        if ending == CSV:
            table.to_csv(partial)
        elif ending == PARQUET:
            try:
                table.to_parquet(partial, engine="pyarrow")
            except ImportError as error:
                raise ScenarioError(
                    f"output = {output.path}: Parquet takes the package pyarrow (pip install pyarrow); "
                    f"install it or choose {CSV} or {MATLAB}"
                ) from error
        else:
            _matlab(table, partial)


def _matlab(table: pandas.DataFrame, path: Any) -> None:
    """Columns under names that MATLAB takes; `names` and `units` say what they are."""
    from scipy.io import savemat

    columns = {str(name): table[name].to_numpy() for name in table}
    short = _short([RUN[0], *columns])
    units = table.attrs["units"]
    values = [table.index.to_numpy(), *columns.values()]
    texts = {"names": [RUN[0], *columns], "units": ["", *(units.get(name, "") for name in columns)]}
    described = {name: np.array(each, dtype=object) for name, each in texts.items()}
    named = dict(zip(short, values, strict=True))
    with open(path, "wb") as file:
        savemat(file, {"runs": named, **described}, long_field_names=True, oned_as="column", do_compression=True)


def _short(names: Sequence[str]) -> list[str]:
    """Different names of letters, digits and underscores that begin with a letter, short enough."""
    import re

    found: list[str] = []
    for name in names:
        plain = re.sub(r"\W+", "_", name, flags=re.ASCII).strip("_") or "x"
        plain = (plain if plain[0].isalpha() else f"x{plain}")[:LONGEST]
        count, new = 1, plain
        while new in found:
            count += 1
            new = f"{plain[: LONGEST - 1 - len(str(count))]}_{count}"
        found.append(new)
    return found
