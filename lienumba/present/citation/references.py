"""The literature behind what lienumba does, as data, and BibTeX of it."""

from collections.abc import Iterable
from typing import NamedTuple


class Reference(NamedTuple):
    """kind: of BibTeX; venue: its journal, publisher, proceedings or institution; numbers: volume(number):pages."""

    kind: str
    authors: str
    year: int
    title: str
    venue: str
    numbers: str = ""
    doi: str = ""


VENUES = {
    "article": "journal", "book": "publisher", "inproceedings": "booktitle", "techreport": "institution",
}  # fmt: skip
REFERENCES = {
    "terze2015": Reference(
        "article", "Terze, Zdravko and Müller, Andreas and Zlatar, Dario", 2015,
        "Lie-group integration method for constrained multibody systems in state space",
        "Multibody System Dynamics", "34(3):275--305", "10.1007/s11044-014-9439-2",
    ),
    "munthekaas1998": Reference(
        "article", "Munthe-Kaas, Hans", 1998, "Runge-Kutta methods on Lie groups",
        "BIT Numerical Mathematics", "38(1):92--111", "10.1007/BF02510919",
    ),
    "munthekaas1999": Reference(
        "article", "Munthe-Kaas, Hans", 1999, "High order Runge-Kutta methods on manifolds",
        "Applied Numerical Mathematics", "29(1):115--127", "10.1016/S0168-9274(98)00030-0",
    ),
    "celledoni2003": Reference(
        "article", "Celledoni, Elena and Marthinsen, Arne and Owren, Brynjulf", 2003,
        "Commutator-free Lie group methods",
        "Future Generation Computer Systems", "19(3):341--352", "10.1016/S0167-739X(02)00161-9",
    ),
    "mueller2014": Reference(
        "article", "Müller, Andreas and Terze, Zdravko", 2014,
        "The significance of the configuration space Lie group for the constraint satisfaction in numerical time "
        "integration of multibody systems",
        "Mechanism and Machine Theory", "82:173--202",
    ),
    "baumgarte1972": Reference(
        "article", "Baumgarte, J.", 1972, "Stabilization of constraints and integrals of motion in dynamical systems",
        "Computer Methods in Applied Mechanics and Engineering", "1(1):1--16", "10.1016/0045-7825(72)90018-7",
    ),
    "runge1895": Reference(
        "article", "Runge, Carl", 1895, "Ueber die numerische Auflösung von Differentialgleichungen",
        "Mathematische Annalen", "46(2):167--178", "10.1007/BF01446807",
    ),
    "heun1900": Reference(
        "article", "Heun, Karl", 1900,
        "Neue Methoden zur approximativen Integration der Differentialgleichungen einer unabhängigen Veränderlichen",
        "Zeitschrift für Mathematik und Physik", "45:23--38",
    ),
    "kutta1901": Reference(
        "article", "Kutta, Wilhelm", 1901,
        "Beitrag zur näherungsweisen Integration totaler Differentialgleichungen",
        "Zeitschrift für Mathematik und Physik", "46:435--453",
    ),
    "dormand1980": Reference(
        "article", "Dormand, J. R. and Prince, P. J.", 1980, "A family of embedded Runge-Kutta formulae",
        "Journal of Computational and Applied Mathematics", "6(1):19--26", "10.1016/0771-050X(80)90013-3",
    ),
    "bogacki1989": Reference(
        "article", "Bogacki, P. and Shampine, L. F.", 1989, "A 3(2) pair of Runge-Kutta formulas",
        "Applied Mathematics Letters", "2(4):321--325", "10.1016/0893-9659(89)90079-7",
    ),
    "tsitouras2011": Reference(
        "article", "Tsitouras, Ch.", 2011,
        "Runge-Kutta pairs of order 5(4) satisfying only the first column simplifying assumption",
        "Computers & Mathematics with Applications", "62(2):770--775", "10.1016/j.camwa.2011.06.002",
    ),
    "hairer1993": Reference(
        "book", "Hairer, Ernst and Nørsett, Syvert P. and Wanner, Gerhard", 1993,
        "Solving Ordinary Differential Equations I: Nonstiff Problems", "Springer", "",
        "10.1007/978-3-540-78862-1",
    ),
    "oneill2014": Reference(
        "techreport", "O'Neill, Melissa E.", 2014,
        "PCG: A family of simple fast space-efficient statistically good algorithms for random number generation",
        "Harvey Mudd College", "HMC-CS-2014-0905",
    ),
    "mckay1979": Reference(
        "article", "McKay, M. D. and Beckman, R. J. and Conover, W. J.", 1979,
        "A comparison of three methods for selecting values of input variables in the analysis of output from a "
        "computer code",
        "Technometrics", "21(2):239--245", "10.1080/00401706.1979.10489755",
    ),
    "sobol1967": Reference(
        "article", "Sobol', I. M.", 1967,
        "On the distribution of points in a cube and the approximate evaluation of integrals",
        "USSR Computational Mathematics and Mathematical Physics", "7(4):86--112", "10.1016/0041-5553(67)90144-9",
    ),
    "joe2008": Reference(
        "article", "Joe, Stephen and Kuo, Frances Y.", 2008,
        "Constructing Sobol sequences with better two-dimensional projections",
        "SIAM Journal on Scientific Computing", "30(5):2635--2654", "10.1137/070709359",
    ),
    "halton1960": Reference(
        "article", "Halton, J. H.", 1960,
        "On the efficiency of certain quasi-random sequences of points in evaluating multi-dimensional integrals",
        "Numerische Mathematik", "2(1):84--90", "10.1007/BF01386213",
    ),
    "saltelli2010": Reference(
        "article",
        "Saltelli, Andrea and Annoni, Paola and Azzini, Ivano and Campolongo, Francesca and Ratto, Marco and "
        "Tarantola, Stefano",
        2010,
        "Variance based sensitivity analysis of model output. Design and estimator for the total sensitivity index",
        "Computer Physics Communications", "181(2):259--270", "10.1016/j.cpc.2009.09.018",
    ),
    "lam2015": Reference(
        "inproceedings", "Lam, Siu Kwan and Pitrou, Antoine and Seibert, Stanley", 2015,
        "Numba: a LLVM-based Python JIT compiler",
        "Proceedings of the Second Workshop on the LLVM Compiler Infrastructure in HPC", ":1--6",
        "10.1145/2833157.2833162",
    ),
    "harris2020": Reference(
        "article", "Harris, Charles R. and Millman, K. Jarrod and van der Walt, Stéfan J. and others", 2020,
        "Array programming with NumPy", "Nature", "585:357--362", "10.1038/s41586-020-2649-2",
    ),
    "virtanen2020": Reference(
        "article", "Virtanen, Pauli and Gommers, Ralf and Oliphant, Travis E. and others", 2020,
        "SciPy 1.0: fundamental algorithms for scientific computing in Python",
        "Nature Methods", "17:261--272", "10.1038/s41592-019-0686-2",
    ),
    "hoyer2017": Reference(
        "article", "Hoyer, Stephan and Hamman, Joe", 2017, "xarray: N-D labeled arrays and datasets in Python",
        "Journal of Open Research Software", "5(1):10", "10.5334/jors.148",
    ),
}  # fmt: skip
LATEX = str.maketrans({
    "ä": r'{\"a}', "ö": r'{\"o}', "ü": r'{\"u}', "é": r"{\'e}", "ø": r"{\o}", "&": r"\&",
})  # fmt: skip


def software(version: str, year: int) -> str:
    """The entry of lienumba itself."""
    return _entry("misc", "lienumba", {
        "author": "{The lienumba developers}",
        "title": "{lienumba: constrained rigid multibody systems on Lie groups}",
        "year": str(year),
        "note": f"Version {version}",
    })  # fmt: skip


def bibtex(keys: Iterable[str]) -> list[str]:
    """The entries with these keys."""
    return [_entry(REFERENCES[key].kind, key, _fields(REFERENCES[key])) for key in keys]


def _fields(reference: Reference) -> dict[str, str]:
    place, _, pages = reference.numbers.partition(":")
    volume, _, number = place.partition("(")
    found = {
        "author": reference.authors,
        "title": f"{{{reference.title}}}",
        VENUES[reference.kind]: reference.venue,
        "year": str(reference.year),
        "number" if reference.kind == "techreport" else "volume": volume,
        "pages": pages,
        "edition": "2nd" if reference.kind == "book" else "",
        "doi": reference.doi,
    }
    return found | ({"number": number.rstrip(")")} if number else {})


def _entry(kind: str, key: str, fields: dict[str, str]) -> str:
    lines = [f"  {name} = {{{text.translate(LATEX)}}}," for name, text in fields.items() if text]
    return "\n".join([f"@{kind}{{{key},", *lines, "}"])
