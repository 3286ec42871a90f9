"""The margin of a requirement as a function of standard normal numbers: samples, runs, margins."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from lienumba.batch.statuses import GOOD
from lienumba.engine.results import Results
from lienumba.engine.sensitivities.seeds import PLACES, differences
from lienumba.engine.simulate import Progress, Runs, Tell, Threads, simulate
from lienumba.errors import Problem, ScenarioError
from lienumba.scenario.resolve import Scenario, resolve
from lienumba.scenario.start.design import draw
from lienumba.scenario.start.prepare import check_initial
from lienumba.store import provenance
from lienumba.store.layout import MARGIN, RUN, VARIABLES, texts
from lienumba.store.linear_layout import KIND, dataset
from lienumba.store.names import FLAGS, one_of
from lienumba.store.shards import LABEL
from lienumba.sweep.distributions.external import Column
from lienumba.sweep.normal import probability
from lienumba.sweep.samplers import SAMPLERS
from lienumba.sweep.samplers.sampler import names_of
from lienumba.sweep.samplers.streams import LARGEST, SMALLEST
from lienumba.words import show

if TYPE_CHECKING:
    import xarray as xr

STEP = 1e-2  # of the differences of inputs, in standard deviations: of sixth order, so exact to 1e-9


@dataclass
class Limit:
    """limit(z): margins (n,) of a requirement in runs whose inputs follow from standard normal numbers (n, d), one for
    each stream of the inputs; NaN where a run failed. All runs are kept: what they were asked for, and what came.
    expected: about how many there will be, for whoever is told; correlate: whether the numbers are independent as yet,
    else they are those of the inputs."""

    scenario: Scenario
    requirement: str
    workers: int
    tell: Tell
    expected: int
    correlate: bool = True
    samples: list[dict[str, np.ndarray]] = field(default_factory=list)
    margins: list[np.ndarray] = field(default_factory=list)
    codes: list[np.ndarray] = field(default_factory=list)

    def __post_init__(self) -> None:
        data, names = self.scenario.data, [x.name for x in self.scenario.data.model.requirements]
        one_of(self.requirement, names, "the scenario", "requirement", "write one as [[requirements]]")
        sampler = SAMPLERS[data.sweep.sampler]
        if sampler.from_table or any(isinstance(kind, Column) for kind in data.sweep.vary.values()):
            raise ScenarioError("sweep.table: samples that are given have no distribution; give sweep.vary instead")
        self.place = names.index(self.requirement)
        self.streams = names_of({path: kind.streams(path) for path, kind in data.sweep.vary.items()})
        if data.model.noise:
            raise ScenarioError(
                "[[noise]]: the margin of a run follows from its inputs alone where rare failures and worst cases are "
                "looked for; leave noise out, or run a sweep and read its verdict"
            )
        if not self.streams:
            raise ScenarioError("sweep.vary: is empty, so no run differs from another; give inputs and their scatter")
        self.nominal = check_initial(self.scenario)
        self.results = Results(self.scenario, self.nominal)
        self.count = self.failed = self.derivatives = self.missing = 0
        self.refused = ""

    @property
    def dimensions(self) -> int:
        return len(self.streams)

    def __call__(self, z: np.ndarray) -> np.ndarray:
        return self._run(z, self.results)[MARGIN]

    def gradient(self, z: np.ndarray) -> tuple[float, np.ndarray, int]:
        """The margin at a point (d,), its exact gradient there, NaN where there is none, and the runs taken."""
        own, missing = self.differentiated, np.full(len(z), np.nan)
        if own is None:
            return np.nan, missing, 0
        judged = self.results.judged[self.place]
        name, place = judged.at
        found = self._run(z[None], own, name, f"d_{name}", FLAGS)
        self.derivatives += 1
        margin, slopes = float(found[MARGIN][0]), found[f"d_{name}"][(0, *place)]
        if found[FLAGS][0] or not np.isfinite(slopes).all():
            self.missing += 1
            return margin, missing, 1
        sign = 1.0 if judged.rises(found[name][(0, *place)]) else -1.0
        moved = self.inputs(np.vstack([z, z + STEP * np.kron(np.eye(len(z)), PLACES[:, None])]))
        by_numbers = differences(np.stack([moved[path] for path in moved], axis=1), np.full(len(z), STEP))
        return margin, sign * slopes @ by_numbers, 1

    @cached_property
    def differentiated(self) -> Results | None:
        """What is kept of runs with derivatives of the margin; None, and why, where there are none."""
        asked = {"of": [self.results.judged[self.place].at[0]]}
        try:
            resolved = resolve({**self.scenario.to_dict(), "sensitivities": asked}, counted=False)
            return Results(resolved, self.nominal)
        except ScenarioError as error:
            self.refused = "; ".join(map(_reason, error.problems))
            return None

    @property
    def notes(self) -> list[str]:
        """A sentence where differences took the place of derivatives."""
        part = f" at {self.missing:,} of {self.derivatives:,} points" if self.missing else ""
        why = f": {self.refused}" if self.refused else ""
        return [f"the margin has no exact derivatives{part}{why}"] if part or why else []

    def _run(self, z: np.ndarray, results: Results, *more: str) -> dict[str, np.ndarray]:
        """Margins, statuses and more variables of runs, in their order."""
        labels, samples = np.arange(self.count, self.count + len(z)), self.inputs(z)
        before, parts = self.count, list[dict[str, np.ndarray]]()

        def tell(event: Progress) -> None:
            total = max(self.expected, before + event.total + 1)
            self.tell(Progress(event.stage, before + event.done, total, self.failed + event.failed))

        for piece in simulate(Runs(labels, samples, self.nominal), tell, Threads(results, self.workers)):
            own: Any = piece.tables["run"]
            parts.append({name: own[name].copy() for name in (LABEL, MARGIN, "status", *more)})
        order = np.argsort(np.concatenate([part[LABEL] for part in parts]))
        found = {name: np.concatenate([part[name] for part in parts])[order] for name in parts[0]}
        found[MARGIN] = found[MARGIN][:, self.place]
        self.count += len(z)
        self.failed += int(np.count_nonzero(~np.isin(found["status"], GOOD)))
        self.samples.append(samples)
        self.margins.append(found[MARGIN])
        self.codes.append(found["status"])
        return found

    def inputs(self, z: np.ndarray) -> dict[str, np.ndarray]:
        """What numbers (n, d) are as inputs, by their paths (n,)."""
        uniform = np.clip(probability(np.asarray(z, float)), SMALLEST, LARGEST)
        by_name = dict(zip(self.streams, uniform.T, strict=True))
        return draw(self.scenario, range(len(z)), by_name, correlate=self.correlate)

    def kept(self) -> dict[str, Any]:
        """Variables of all runs so far."""
        margins, codes = np.concatenate(self.margins), np.concatenate(self.codes)
        margin, status = (texts(VARIABLES[name].units, VARIABLES[name].long_name) for name in (MARGIN, "status"))
        return {MARGIN: (VARIABLES[MARGIN].dims, margins[:, None], margin), "status": (RUN, codes, status)}

    @property
    def units(self) -> str:
        return next(one.units for one in self.results.judged if one.requirement.name == self.requirement)

    def units_of(self, path: str) -> str:
        """Those of an input."""
        return self.scenario.units(path)

    def dataset(
        self, kind: str, what: str, variables: Mapping[str, Any], coordinates: Mapping[str, Any], **more: Any
    ) -> "xr.Dataset":
        """The one of this kind that is made of all runs so far; what: for its title; more: attributes."""
        own = self.scenario
        title = ": ".join(filter(None, [own.data.title, what]))
        said = provenance.attributes(title, own.to_toml(), own.sha256(), own.data.sweep.seed, provenance.command())
        of = {"requirement": [self.requirement], "requirement_units": ("requirement", [self.units])}
        samples = {path: np.concatenate([x[path] for x in self.samples]) for path in self.samples[0]}
        every = {RUN[0]: np.arange(self.count), **of, **coordinates}
        counts = {"runs_with_derivatives": self.derivatives, "notes": "\n".join(self.notes)}
        attributes = {KIND: kind, **said, "requirement": self.requirement, **counts, **more}
        return dataset(variables, every, samples, {path: self.units_of(path) for path in samples}, attributes)


def _reason(problem: Problem) -> str:
    """Why there is no derivative, without the section that nobody wrote."""
    what = problem.rule.partition("which ")[2]
    return f"{show(problem.value)} {what}" if what else f"{problem.place} = {show(problem.value)}: {problem.rule}"


def named(resolved: Scenario, requirement: str | None) -> str:
    """The requirement that is meant: the only one where none is named."""
    names: Sequence[str] = [x.name for x in resolved.data.model.requirements]
    if not names:
        raise ScenarioError("the scenario has no requirements, so nothing can fail; write one as [[requirements]]")
    if requirement is None and len(names) > 1:
        raise ScenarioError(f"there are {len(names)} requirements; name one of {', '.join(map(show, names))}")
    return requirement if requirement is not None else names[0]
