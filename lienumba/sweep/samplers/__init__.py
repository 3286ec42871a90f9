"""The uniform numbers behind samples: a stream for each run and path, and how samplers draw from them."""

from collections.abc import Mapping

from lienumba.errors import ScenarioError
from lienumba.sweep.samplers.halton import HALTON
from lienumba.sweep.samplers.importance import IMPORTANCE
from lienumba.sweep.samplers.independent import RANDOM, TABLE
from lienumba.sweep.samplers.latin_hypercube import LATIN_HYPERCUBE
from lienumba.sweep.samplers.morris import MORRIS
from lienumba.sweep.samplers.sampler import SAMPLERS, Sampler
from lienumba.sweep.samplers.sobol import SALTELLI, SOBOL

__all__ = ["DEFAULT", "GROWING", "INDICES", "RETIRED", "SAMPLERS", "Sampler", "sampler_of"]

DEFAULT = RANDOM.name
GROWING = SOBOL.name  # what is proposed for sweeps that are to grow, and for correlated inputs
INDICES = SALTELLI.name  # what is proposed for Sobol' indices

for sampler in (RANDOM, LATIN_HYPERCUBE, SOBOL, HALTON, TABLE, SALTELLI, MORRIS, IMPORTANCE):
    SAMPLERS.add(sampler)
# Of datasets of older versions, which have their samples.
RETIRED = {"saltelli_second": Sampler("saltelli_second", SALTELLI.draw, row=lambda n: 2 * n + 2, independent_of_row=2)}


def sampler_of(sweep: Mapping[str, object]) -> Sampler:
    """Return the sampler of the section [sweep] of a dataset, which may be from another version of lienumba."""
    name = str(sweep.get("sampler", DEFAULT))
    if name not in SAMPLERS and name not in RETIRED:
        known = "this version of lienumba does not know it; analyse the dataset with the version that made it"
        raise ScenarioError(f'sweep.sampler = "{name}": {known}')
    return RETIRED[name] if name in RETIRED else SAMPLERS[name]
