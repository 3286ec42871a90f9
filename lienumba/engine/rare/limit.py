"""The margin of a requirement as a function of standard normal numbers: samples, runs, margins."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from lienumba.batch.statuses import GOOD
from lienumba.engine.results import Results
from lienumba.engine.simulate import Progress, Runs, Tell, Threads, simulate
from lienumba.errors import ScenarioError
from lienumba.scenario.resolve import Scenario
from lienumba.scenario.start.design import draw
from lienumba.scenario.start.prepare import check_initial
from lienumba.store import provenance
from lienumba.store.layout import MARGIN, RUN, VARIABLES, texts
from lienumba.store.linear_layout import KIND, dataset
from lienumba.store.names import one_of
from lienumba.store.shards import LABEL
from lienumba.sweep.distributions.external import Column
from lienumba.sweep.normal import probability
from lienumba.sweep.samplers import SAMPLERS
from lienumba.sweep.samplers.sampler import names_of
from lienumba.sweep.samplers.streams import LARGEST, SMALLEST
from lienumba.words import show

if TYPE_CHECKING:
    import xarray as xr


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
        self.count = self.failed = 0

    @property
    def dimensions(self) -> int:
        return len(self.streams)

    def __call__(self, z: np.ndarray) -> np.ndarray:
        labels, samples = np.arange(self.count, self.count + len(z)), self.inputs(z)
        found, codes = np.full(len(z), np.nan), np.zeros(len(z), np.int8)
        runs = Runs(labels, samples, self.nominal)
        before = self.count

        def tell(event: Progress) -> None:
            total = max(self.expected, before + event.total + 1)
            self.tell(Progress(event.stage, before + event.done, total, self.failed + event.failed))

        for piece in simulate(runs, tell, Threads(self.results, self.workers)):
            own: Any = piece.tables["run"]
            at = own[LABEL] - before
            found[at], codes[at] = own[MARGIN][:, self.place], own["status"]
        self.count += len(z)
        self.failed += int(np.count_nonzero(~np.isin(codes, GOOD)))
        self.samples.append(samples)
        self.margins.append(found)
        self.codes.append(codes)
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
        attributes = {KIND: kind, **said, "requirement": self.requirement, **more}
        return dataset(variables, every, samples, {path: self.units_of(path) for path in samples}, attributes)


def named(resolved: Scenario, requirement: str | None) -> str:
    """The requirement that is meant: the only one where none is named."""
    names: Sequence[str] = [x.name for x in resolved.data.model.requirements]
    if not names:
        raise ScenarioError("the scenario has no requirements, so nothing can fail; write one as [[requirements]]")
    if requirement is None and len(names) > 1:
        raise ScenarioError(f"there are {len(names)} requirements; name one of {', '.join(map(show, names))}")
    return requirement if requirement is not None else names[0]
