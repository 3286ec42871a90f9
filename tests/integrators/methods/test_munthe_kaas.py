"""One step in plain Python: times of stages, and how slopes are weighted, by quadrature."""

import pytest

from lienumba.groups import state
from lienumba.integrators.methods import munthe_kaas
from lienumba.integrators.methods.charts import R3xSO3
from tests.facade import METHODS

EXPLICIT = [name for name, tableau in METHODS.items() if not (tableau.implicit or tableau.series)]


@pytest.mark.parametrize("name", EXPLICIT)
def test_a_slope_of_the_time_alone_is_integrated_to_the_order(name: str) -> None:
    """A velocity t^(p - 1) and a turn about one axis that is as fast, by a method of order p."""
    tableau, t, h = METHODS[name], 0.3, 0.4
    p = tableau.order

    def stage(x: object, u: object, t: float) -> list[tuple[float, ...]]:
        rate = t ** (p - 1)
        return [(rate, 0.0, 0.0, 0.0, 0.0, rate, *[0.0] * 6)]

    (end,), *_ = munthe_kaas.step(R3xSO3(None), tableau, (state.IDENTITY,), t, h, stage)
    way = ((t + h) ** p - t**p) / p
    assert end[0] == pytest.approx(way, rel=1e-13)
    assert state.log(end)[5] == pytest.approx(way, rel=1e-13)
