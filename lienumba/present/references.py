"""Publications that belong to no registered element, and BibTeX of all that a citation may name."""

from collections.abc import Iterable
from unicodedata import normalize

from lienumba.integrators.methods import METHODS
from lienumba.integrators.methods.charts import GROUPS
from lienumba.keys.literature import Reference
from lienumba.sweep.samplers import SAMPLERS

VENUES = {
    "article": "journal", "book": "publisher", "inproceedings": "booktitle", "techreport": "institution",
}  # fmt: skip
LITERATURE = (
    Reference(
        "terze2015", "article", "Terze, Zdravko and Müller, Andreas and Zlatar, Dario", 2015,
        "Lie-group integration method for constrained multibody systems in state space",
        "Multibody System Dynamics", "34(3):275--305", "10.1007/s11044-014-9439-2",
    ),
    Reference(
        "munthekaas1998", "article", "Munthe-Kaas, Hans", 1998, "Runge-Kutta methods on Lie groups",
        "BIT Numerical Mathematics", "38(1):92--111", "10.1007/BF02510919",
    ),
    Reference(
        "munthekaas1999", "article", "Munthe-Kaas, Hans", 1999, "High order Runge-Kutta methods on manifolds",
        "Applied Numerical Mathematics", "29(1):115--127", "10.1016/S0168-9274(98)00030-0",
    ),
    Reference(
        "featherstone2008", "book", "Featherstone, Roy", 2008, "Rigid Body Dynamics Algorithms", "Springer", "",
        "10.1007/978-1-4899-7560-7",
    ),
    Reference(
        "baumgarte1972", "article", "Baumgarte, J.", 1972,
        "Stabilization of constraints and integrals of motion in dynamical systems",
        "Computer Methods in Applied Mechanics and Engineering", "1(1):1--16", "10.1016/0045-7825(72)90018-7",
    ),
    Reference(
        "hunt1975", "article", "Hunt, K. H. and Crossley, F. R. E.", 1975,
        "Coefficient of restitution interpreted as damping in vibroimpact",
        "Journal of Applied Mechanics", "42(2):440--445", "10.1115/1.3423596",
    ),
    Reference(
        "lam2015", "inproceedings", "Lam, Siu Kwan and Pitrou, Antoine and Seibert, Stanley", 2015,
        "Numba: a LLVM-based Python JIT compiler",
        "Proceedings of the Second Workshop on the LLVM Compiler Infrastructure in HPC", ":1--6",
        "10.1145/2833157.2833162",
    ),
    Reference(
        "harris2020", "article", "Harris, Charles R. and Millman, K. Jarrod and van der Walt, Stéfan J. and others",
        2020, "Array programming with NumPy", "Nature", "585:357--362", "10.1038/s41586-020-2649-2",
    ),
    Reference(
        "virtanen2020", "article", "Virtanen, Pauli and Gommers, Ralf and Oliphant, Travis E. and others", 2020,
        "SciPy 1.0: fundamental algorithms for scientific computing in Python",
        "Nature Methods", "17:261--272", "10.1038/s41592-019-0686-2",
    ),
    Reference(
        "hoyer2017", "article", "Hoyer, Stephan and Hamman, Joe", 2017,
        "xarray: N-D labeled arrays and datasets in Python",
        "Journal of Open Research Software", "5(1):10", "10.5334/jors.148",
    ),
)  # fmt: skip
ACCENTS = {
    "\u0300": "`", "\u0301": "'", "\u0302": "^", "\u0303": "~", "\u0304": "=", "\u0306": "u", "\u0307": ".",
    "\u0308": '"',
    "\u030a": "r", "\u030b": "H", "\u030c": "v", "\u0327": "c", "\u0328": "k",
}  # fmt: skip
LETTERS = {"ø": r"{\o}", "Ø": r"{\O}", "ł": r"{\l}", "Ł": r"{\L}", "ß": r"{\ss}", "æ": r"{\ae}", "&": r"\&"}


def software(version: str, year: int) -> str:
    """The entry of lienumba itself."""
    return _entry("misc", "lienumba", {
        "author": "{The lienumba developers}",
        "title": "{lienumba: constrained rigid multibody systems on Lie groups}",
        "year": str(year),
        "note": f"Version {version}",
    })  # fmt: skip


def references() -> dict[str, Reference]:
    """Every reference by its key."""
    elements = (*METHODS.values(), *GROUPS.values(), *SAMPLERS.values())
    return {x.key: x for x in (*LITERATURE, *(x for element in elements for x in element.references))}


def bibtex(keys: Iterable[str]) -> list[str]:
    """The entries with these keys."""
    every = references()
    return [_entry(every[key].kind, key, _fields(every[key])) for key in keys]


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


def _latex(text: str) -> str:
    """In ASCII, as BibTeX knows it."""
    return "".join(map(_letter, text))


def _letter(letter: str) -> str:
    apart = normalize("NFD", letter)
    plain, accents = apart[:1], apart[1:]
    if accents in ACCENTS:
        accent = ACCENTS[accents]
        return f"{{\\{accent}{{{plain}}}}}" if accent.isalpha() else f"{{\\{accent}{plain}}}"
    return LETTERS.get(letter, letter)


def _entry(kind: str, key: str, fields: dict[str, str]) -> str:
    lines = [f"  {name} = {{{_latex(text)}}}," for name, text in fields.items() if text]
    return "\n".join([f"@{kind}{{{key},", *lines, "}"])
