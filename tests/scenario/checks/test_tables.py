"""Wrong tables, in the scenario and in files: one clear message each, the same from both commands."""

from pathlib import Path

import netCDF4
import pytest

from tests.scenario.checks.refusal import check_refused, refused_by_both, rig
from tests.scenario.checks.test_formulas import slide, table, torque


def times(*lines: str, text: str = "push(t)") -> str:
    return rig(table(*lines), torque(text))


VALUES = "values = [1, 2]"
TABLES = {
    "too short for the run": (
        times("times = [0, 0.005]", VALUES),
        'tables.push: ends at 0.005, but model.forces.push.value[1] = "push(t)" reads it until 0.01; add a point '
        'there, end the run earlier, or give outside = "hold" or 0',
    ),
    "late for the run": (
        times("times = [0.005, 1]", VALUES, 'outside = "error"'),
        'tables.push: begins at 0.005, but model.forces.push.value[1] = "push(t)" reads it from 0 on; add a point '
        'there, or give outside = "hold" or 0',
    ),
    "a key of files": (
        times("times = [0, 1]", VALUES, "offset = 1"),
        "tables.push.file is missing; offset is of a file: give the path of a CSV or netCDF file, or leave offset out",
    ),
    "nothing": (
        rig("[tables.push]\n", torque("push(t)")),
        'tables.push.times is missing; give file = "profile.csv" with time and value, or times and values',
    ),
    "file and numbers": (
        times('file = "a.csv"', 'time = "t"', 'value = "F"', VALUES),
        "tables.push.values: the numbers come from file already; leave out either file or times and values",
    ),
}

# More of these rules: the place, and words of the rule.
MORE = {
    "tables.push: has 1 of at least 2 points": times("times = [0]", "values = [1]"),
    "tables.push: has 3 times and 2 values": times("times = [0, 1, 2]", VALUES),
    "tables.push.times[2]: does not come after": times("times = [0, 1, 1]", "values = [1, 2, 3]"),
    "tables.push.values[1]: must be a finite number": times("times = [0, 1]", "values = [1, nan]"),
    "tables.push.interpolation: is not known": times("times = [0, 1]", VALUES, 'interpolation = "linar"'),
    "model.drivers.drive.value: jumps by 0.5 at t = 0.005": rig(
        table("times = [0, 0.005, 1]", "values = [0, 1, 2]", 'interpolation = "hold"'), slide("push(t)/2")
    ),
}


FILES = {
    "none.csv": (None, "F", 'file = "none.csv": there is no such file; check the path'),
    "column.csv": ("t,F\n0,1\n1,2\n", "G", 'file = "column.csv": has no column "G"; known here are "t", "F"'),
    "text.csv": (
        "# thrust\nt,F\n0,1\n1,two\n",
        "F",
        'file = "text.csv": line 4, column F: "two" is no number; correct it',
    ),
    "ragged.csv": ("t;F\n0;1\n1\n", "F", 'file = "ragged.csv": line 3, column F: "" is no number; correct it'),
    "nan.csv": (
        "t,F\n0,1\n1,nan\n",
        "F",
        "values[1] = nan: must be a finite number; correct it, or leave the point out",
    ),
    "back.csv": ("t F\n0 1\n1 2\n0.5 3\n", "F", "times[2] = 0.5: does not come after 1.0; the times must increase"),
    "twice.csv": (
        "t,F,F\n0,0,5\n1,2,5\n",
        "F",
        'file = "twice.csv": columns 2 and 3 are both called "F"; give each its own name',
    ),
    "comma.csv": ("t;F\n0,0;0,0\n1,0;2,0\n", "F", 'file = "comma.csv": has decimal commas; give decimal = ","'),
    "one comma.csv": (
        "t;F\n0;0\n1;2,5\n",
        "F",
        'file = "one comma.csv": line 3, column F: "2,5" has a decimal comma; give decimal = ","',
    ),
    "motor.eng": (
        "; comment\nG80 29 124 7 0.06 0.13 X\n 0.01 20\n 1.0 30\n",
        "F",
        'file = "motor.eng": ".eng" is no format of tables that is read; save it as CSV with the names of the columns '
        "first",
    ),
    "no names.csv": (
        "0,1\n1,2\n",
        "F",
        'file = "no names.csv": has numbers in its first line, where the names of the columns belong; give a first '
        "line with the names of the columns, numbers below",
    ),
    "units.csv": (
        "t,F\ns,kN\n0,1\n1,2\n",
        "F",
        'file = "units.csv": column F is in "kN", and numbers are in SI units; convert the column, or remove the line '
        "of units and scale the table in formulas",
    ),
    "empty.csv": (
        "",
        "F",
        'file = "empty.csv": is empty; give a first line with the names of the columns, and numbers below',
    ),
}


TABLES |= {wanted: (text, wanted) for wanted, text in MORE.items()}


@pytest.mark.parametrize("case", TABLES)
def test_wrong_table(tmp_path: Path, case: str) -> None:
    check_refused(tmp_path, *TABLES[case])


def from_file(name: str, column: str) -> str:
    return times(f'file = "{name}"', 'time = "t"', f'value = "{column}"')


@pytest.mark.parametrize("name", FILES)
def test_wrong_file(tmp_path: Path, name: str) -> None:
    content, column, message = FILES[name]
    if content is not None:
        (tmp_path / name).write_text(content, encoding="utf-8")
    assert refused_by_both(tmp_path, from_file(name, column)) == [f"tables.push.{message}"]


def test_a_folder_is_no_file(tmp_path: Path) -> None:
    (tmp_path / "data").mkdir()
    wanted = 'tables.push.file = "data": is a folder; give the path of a file in it'
    assert refused_by_both(tmp_path, from_file("data", "F")) == [wanted]


def test_one_row(tmp_path: Path) -> None:
    (tmp_path / "one.csv").write_text("t,F\n0,1\n", encoding="utf-8")
    wanted = "tables.push: has 1 of at least 2 points; give more, or write a number instead"
    assert refused_by_both(tmp_path, from_file("one.csv", "F")) == [wanted]


def test_no_name_of_a_column(tmp_path: Path) -> None:
    assert refused_by_both(tmp_path, times('file = "a.csv"')) == [
        "tables.push.value is missing; give the name of a column of a.csv in quotes"
    ]


def test_wrong_variables_of_netcdf(tmp_path: Path) -> None:
    with netCDF4.Dataset(tmp_path / "a.nc", "w") as file:
        file.createDimension("n", 2)
        file.createVariable("t", float, ("n",))[:] = [0, 1]
        file.createVariable("F", float, ("n", "n"))[:] = [[0, 1], [2, 3]]
    for column in ("F", "G"):
        wanted = f'tables.push.file = "a.nc": has no column "{column}"; known here are "t"'
        assert refused_by_both(tmp_path, from_file("a.nc", column)) == [wanted]


@pytest.mark.parametrize("name", ["bad.nc", "latin.csv"])
def test_files_that_cannot_be_read(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_bytes("t,F\n0,1\n1,\xb5\n".encode("latin-1"))
    (message,) = refused_by_both(tmp_path, from_file(name, "F"))
    assert message.startswith(f'tables.push.file = "{name}": ')
    assert "; " in message
    assert not any(word in message for word in ("codec", "Errno"))
