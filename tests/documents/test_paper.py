"""The tables of docs/paper.md are true, and so are the sentences beside them; the figures are drawn."""

import re
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.rigs.places import scripts_on_path

with scripts_on_path():
    import document
    from section7 import measures, numbers, runs, tables

SHOWN = ("03", "04", "05", "07", "08", "10", "15", "19", "22")  # of the figures, one of each kind


@pytest.mark.release
@pytest.mark.parametrize("name", tables.TABLES)
def test_the_document_has_what_is_computed(name: str) -> None:
    assert document.in_document(tables.DOCUMENT, name) == tables.TABLES[name](), "scripts/paper renews docs/paper.md"


def test_every_number_of_section_7_is_there() -> None:
    text = tables.DOCUMENT.read_text(encoding="utf-8")
    for number in (
        "7.393e-8",
        "7.359e-12",
        "7.196e-8",
        "7.199e-12",
        "5e-4",
        "1e-7",
        "1e-10",
        "1e-11",
        "1e-14",
        "1e-24",
    ):
        assert re.search(rf"\| {number} \|", text), number
    shown = {int(figure) for figure in re.findall(r"^\| (\d+) \|", text, re.MULTILINE)}
    assert shown == {8, 9, 10, 11, 12, 13, 14, 15, 18, 19, 20, 21, 22, 23, 24, 25}


def test_the_weights_differ_by_the_error_of_the_motion() -> None:
    for name, step, gain in (("heavy_top", 1e-4, 6.0), ("satellite", 0.1, 1.5)):
        free, plain, weighted, velocities = (
            runs.error(name, step, *form)
            for form in (("none", "none"), ("local", "identity"), ("local", "mass"), ("none", "mass"))
        )
        assert gain < plain / weighted < 1.5 * gain
        assert weighted < plain < free
        assert velocities < plain


def test_both_forms_of_the_projection_lead_to_the_same_motion() -> None:
    """The top is corrected by some 1e-6 in each of 2,000 steps, and spins."""
    for name, step, bound in (("heavy_top", 1e-3, 5e-12), ("satellite", 0.1, 1e-13)):
        local, embedded = (runs.simulated(name, step, form, "mass") for form in ("local", "embedded"))
        for part in runs.PARTS.values():
            np.testing.assert_allclose(embedded[part], local[part], rtol=0, atol=bound)


def test_most_of_the_tops_positions_are_met_exactly() -> None:
    found = numbers.top_errors(runs.simulated("heavy_top", 1e-5, "local", "identity", 1e-14))["position"]
    assert 0.85 < (found == 0.0).mean() < 0.95


def test_without_projection_the_satellite_stays_below_the_papers_tolerance() -> None:
    for step, left in ((1e-2, 2.3e-11), (1e-3, 1.6e-13)):
        assert float(runs.simulated("satellite", step)["position_violation"][-1]) == pytest.approx(left, rel=0.02)


def test_measures_against_scipy() -> None:
    rotations = Rotation.random(50, rng=np.random.default_rng(7))
    R = rotations.as_matrix()
    psi, theta, phi = rotations.as_euler("ZYX").T
    np.testing.assert_allclose(measures.tait_bryan(R), (phi, theta, psi), atol=1e-12)
    np.testing.assert_allclose(measures.rotation_vector(R), rotations.as_rotvec(), atol=1e-9)
    A = R + 0.1 * np.random.default_rng(8).standard_normal(R.shape)
    np.testing.assert_allclose(measures.determinant(A), np.linalg.det(A), atol=1e-14)
    np.testing.assert_allclose(measures.gram(A), A @ A.transpose(0, 2, 1), atol=1e-14)
    np.testing.assert_allclose(measures.rotated(A, A[:, 0]), (A @ A[:, 0, :, None])[..., 0], atol=1e-14)


def test_numbers_as_words() -> None:
    found = [document.text(x) for x in (7.393e-8, 4.44e-11, 1e-3, 5e-4, 0.5, 2.0, 1e8, 0.0)]
    assert found == ["7.393e-8", "4.44e-11", "1e-3", "5e-4", "0.5", "2", "1e8", "0"]
    assert document.text(3.1e-16, rounding=True) == "< 1e-15"
    assert tables.ratio(4.4358e-7, 7.393e-8) == "6.000"
    assert tables.ratio(3e-16, 1e-7) == "< 1e-8"


@pytest.mark.release
def test_figures_are_drawn(tmp_path: Path) -> None:
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    with scripts_on_path():
        from section7 import figures
    assert sorted(map(int, figures.FIGURES)) == [*range(3, 16), *range(18, 26)]
    for number in SHOWN:
        picture = matplotlib.image.imread(figures.draw(tmp_path, number))
        assert picture.std() > 0.05  # not blank
        assert (picture[:3] == 1.0).all()  # nothing reaches the edges
        assert (picture[-3:] == 1.0).all()
