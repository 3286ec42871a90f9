"""A System as people see it: in a few lines of text, or a table of a notebook, finished or not."""

from collections.abc import Iterator, Mapping
from html import escape

from lienumba.errors import MISSING, ScenarioError
from lienumba.mechanics.elements.inputs import input_form
from lienumba.scenario.base.paths import BESIDE, INPUTS
from lienumba.scenario.base.problems import tables
from lienumba.words import plural, printable, show

MOST = 6  # things of one kind that are shown
PROBLEMS = 3  # that are shown
LONGEST = 60  # of a value
# Of each thing what says most of it, in this order.
FACTS = {
    "bodies": ("mass",),
    "joints": ("type", "bodies", "joints"),
    "drivers": ("joint", "body", "motion", "coordinate", "value", "rate"),
    "forces": ("type", "bodies", "joint", "body", "stiffness", "damping", "value", "function"),
    "quantities": ("type", "body", "joint", "value"),
    "noise": ("type", "std", "every"),
    "limits": ("joint", "coordinate", "low", "high"),
    "contacts": ("type", "bodies", "friction", "stiffness"),
    "events": ("when", "action", "joint", "parameters"),
    "requirements": ("value", "below", "above", "between", "probability"),
}
PLAIN = ("type", "bodies", "joints")  # keys whose values say what they are
VARIED = ("distribution", "scipy", "expression", "column")
NAMED = ("integrator", "projection", "output", "study")  # sections that are shown as they are


def _mapping(x: object) -> Mapping[str, object]:
    return x if isinstance(x, Mapping) else {}


def _input(x: object) -> str:
    """A number or a formula; of a table how it is written."""
    return str(input_form(x) or "?") if isinstance(x, Mapping) else _value(x)


def rows(data: Mapping[str, object], source: object) -> Iterator[tuple[str, str]]:
    """What a scenario has, by kind, and what it comes to, or what is wrong with it; source: what `resolve` takes."""
    model = data.get("model")
    model = model if isinstance(model, Mapping) else {}
    for kind, facts in FACTS.items():
        listed = [*tables(model.get(kind)), *(tables(data.get(kind)) if kind in BESIDE else [])]
        if listed:
            yield kind, _cut([_thing(item, facts) for item in listed])
    inputs = {**_mapping(model.get(INPUTS)), **_mapping(data.get(INPUTS))}
    for kind, named in (("parameters", _mapping(data.get("parameters"))), (INPUTS, inputs)):
        if named:
            yield kind, _cut([f"{name} = {_input(x)}" for name, x in named.items()])
    for name in NAMED:
        section = data.get(name)
        if isinstance(section, Mapping) and section:
            yield name, _cut([f"{key} = {_value(x)}" for key, x in section.items()])
    sweep = data.get("sweep")
    if isinstance(sweep, Mapping) and sweep:
        yield "sweep", _cut([f"{key} = {_value(x)}" for key, x in sweep.items() if key != "vary"])
        vary = sweep.get("vary")
        if isinstance(vary, Mapping) and vary:
            yield "varied", _cut([f"{path} ({_distribution(x)})" for path, x in vary.items()])
    yield from _verdict(source)


def as_text(title: str, found: list[tuple[str, str]]) -> str:
    """Rows as lines."""
    width = max(len(kind) for kind, _ in found)
    return "\n".join([_headed(title), *(f"  {kind:<{width}}  {text}" for kind, text in found)])


def as_html(title: str, found: list[tuple[str, str]]) -> str:
    """Rows as a table."""
    left = ' style="text-align: left; vertical-align: top"'
    lines = [f"<tr><th{left}>{kind}</th><td{left}>{escape(text)}</td></tr>" for kind, text in found]
    return f"<table><caption{left}>{escape(_headed(title))}</caption>{''.join(lines)}</table>"


def _headed(title: str) -> str:
    return f"System {show(title)}" if title else "System"


def _thing(item: Mapping[str, object], facts: tuple[str, ...]) -> str:
    """One body, joint, ... by its name and what says most of it."""
    told = [
        _plain(item[key]) if key in PLAIN else f"{key} {_value(item[key])}"
        for key in facts
        if item.get(key) is not None
    ]
    name = printable(str(item.get("name", "")))
    inside = ", ".join(told)
    return f"{name} ({inside})" if name and inside else name or inside


def _plain(value: object) -> str:
    """Names, without quotes."""
    return " - ".join(map(str, value)) if isinstance(value, list | tuple) else printable(str(value))


def _value(value: object) -> str:
    text = show(value.tolist() if hasattr(value, "tolist") else value)
    return text if len(text) <= LONGEST else text[: LONGEST - 4] + " ..."


def _distribution(varied: object) -> str:
    """How a number varies, in a word or two."""
    given = varied if isinstance(varied, Mapping) else {}
    return next((printable(str(given[key])) for key in VARIED if key in given), "?")


def _cut(texts: list[str]) -> str:
    more = len(texts) - MOST
    return ", ".join([*texts[:MOST], *([f"and {more:,} more"] if more > 0 else [])])


def _verdict(source: object) -> Iterator[tuple[str, str]]:
    """The size of a scenario that can be run; else what is to be mended first."""
    from lienumba.scenario.resolve import resolve

    try:
        yield "ready", resolve(source).headline()
    except ScenarioError as error:
        for problem in error.problems[:PROBLEMS]:
            yield "missing" if problem.verb == MISSING else "wrong", printable(str(problem))
        more = len(error.problems) - PROBLEMS
        if more > 0:
            yield "", f"and {plural(more, 'more problem', 'more problems')}"
    except Exception as error:  # what is shown must never fail
        yield "wrong", printable(f"{type(error).__name__}: {error}")
