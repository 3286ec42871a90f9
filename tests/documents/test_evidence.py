"""docs/evidence.md has what the script computes: the digits that others printed against ours. Its times are not looked
at."""

import re

import pytest

from tests.rigs.places import scripts_on_path

with scripts_on_path():
    import document
    import published

NUMBER = re.compile(r"-?\d+\.?\d*(?:e-?\d+)?")
QUICK = ("pendulum", "euler_disc")
EIGENVALUES = [name for name in published.NAMES if "eigenvalues" in published.result(name)]


def in_document(name: str) -> str:
    """The section of a result on the page."""
    title = published.result(name)["title"]
    (found,) = re.findall(
        rf"### {re.escape(title)}\n.*?(?=\n\n### |\Z)", document.in_document(published.DOCUMENT, "results"), re.DOTALL
    )
    return found


@pytest.mark.parametrize("name", QUICK)
def test_results_are_those_of_the_script(name: str) -> None:
    assert published.section(name) == in_document(name), "scripts/evidence renews docs/evidence.md"


@pytest.mark.release
@pytest.mark.parametrize("name", [name for name in published.NAMES if name not in (*QUICK, *EIGENVALUES)])
def test_all_results_are_those_of_the_script(name: str) -> None:
    assert published.section(name) == in_document(name), "scripts/evidence renews docs/evidence.md"


@pytest.mark.release
@pytest.mark.parametrize("name", EIGENVALUES)
def test_eigenvalues_are_those_of_the_script(name: str) -> None:
    """LAPACK rounds differently on other CPUs."""
    here, there = published.section(name), in_document(name)
    assert NUMBER.sub("#", here) == NUMBER.sub("#", there)
    found, wanted = ([float(x) for x in NUMBER.findall(text)] for text in (here, there))
    assert found == pytest.approx(wanted, rel=1e-11, abs=1e-11)


def test_every_result_has_its_row() -> None:
    """At least fifteen, each with a section, and no claim that does not hold."""
    rows = document.in_document(published.DOCUMENT, "overview").splitlines()[2:]
    assert len(rows) == len(published.NAMES) >= 15
    for row, name in zip(rows, published.NAMES, strict=True):
        assert row.startswith(f"| [{published.result(name)['title']}](#")
        assert in_document(name)
    assert "**no**" not in published.DOCUMENT.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("printed", "here", "agreed"),
    [
        ("3.1416", 3.14159265, 5), ("3.1415", 3.14159265, 4), ("-0.0123", -0.0124, 2), ("1.500e-3", 0.0015, 4),
        ("0.00000", 3e-4, 3), ("0.00000", 0.0, 5), ("10.0", 9.96, 3), ("11", 11.0, 2), ("2.0", -2.0, 0),
    ],
)  # fmt: skip
def test_digits_that_agree(printed: str, here: float, agreed: int) -> None:
    assert published.agreed_digits(printed, here) == agreed
