"""The classical methods, and the commutator-free one: of steps of given length."""

from lienumba.integrators.methods.tableau import Tableau
from lienumba.keys.literature import Reference

RUNGE = Reference(
    "runge1895", "article", "Runge, Carl", 1895, "Ueber die numerische Auflösung von Differentialgleichungen",
    "Mathematische Annalen", "46(2):167--178", "10.1007/BF01446807",
)  # fmt: skip
HEUN = Reference(
    "heun1900", "article", "Heun, Karl", 1900,
    "Neue Methoden zur approximativen Integration der Differentialgleichungen einer unabhängigen Veränderlichen",
    "Zeitschrift für Mathematik und Physik", "45:23--38",
)  # fmt: skip
KUTTA = Reference(
    "kutta1901", "article", "Kutta, Wilhelm", 1901,
    "Beitrag zur näherungsweisen Integration totaler Differentialgleichungen",
    "Zeitschrift für Mathematik und Physik", "46:435--453",
)  # fmt: skip
CELLEDONI = Reference(
    "celledoni2003", "article", "Celledoni, Elena and Marthinsen, Arne and Owren, Brynjulf", 2003,
    "Commutator-free Lie group methods",
    "Future Generation Computer Systems", "19(3):341--352", "10.1016/S0167-739X(02)00161-9",
)  # fmt: skip

CLASSICAL = (
    Tableau.of("euler", 1, "the explicit Euler method", [""], "1"),
    Tableau.of("midpoint", 2, "the explicit midpoint rule [@runge1895]", ["", "1/2"], "0 1", RUNGE),
    Tableau.of("heun", 2, "Heun's method [@heun1900]", ["", "1"], "1/2 1/2", HEUN),
    Tableau.of("kutta3", 3, "Kutta's method [@kutta1901]", ["", "1/2", "-1 2"], "1/6 2/3 1/6", KUTTA),
    Tableau.of(
        "rk4", 4, "the classical Runge-Kutta method [@kutta1901]",
        ["", "1/2", "0 1/2", "0 0 1"], "1/6 1/3 1/3 1/6", KUTTA,
    ),
    Tableau.of(
        "cf4", 4, "the commutator-free method of Celledoni, Marthinsen and Owren [@celledoni2003]",
        ["", "1/2", "0 1/2", "0 0 1"], "1/6 1/3 1/3 1/6", CELLEDONI,
        first=["", "", "", "1/2 0 0", "1/4 1/6 1/6 -1/12"], flat="rk4",
    ),
    Tableau.of(
        "rk38", 4, "Kutta's 3/8 rule [@kutta1901]", ["", "1/3", "-1/3 1", "1 -1 1"], "1/8 3/8 3/8 1/8", KUTTA
    ),
)  # fmt: skip
