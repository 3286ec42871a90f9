"""The uniform numbers behind samples: a stream for each run and path, and how samplers draw from them."""

from lienumba.sweep.samplers.halton import HALTON
from lienumba.sweep.samplers.importance import IMPORTANCE
from lienumba.sweep.samplers.independent import RANDOM, TABLE
from lienumba.sweep.samplers.latin_hypercube import LATIN_HYPERCUBE
from lienumba.sweep.samplers.morris import MORRIS
from lienumba.sweep.samplers.sampler import SAMPLERS, Sampler
from lienumba.sweep.samplers.sobol import SALTELLI, SALTELLI_SECOND, SOBOL

__all__ = ["DEFAULT", "GROWING", "INDICES", "SAMPLERS", "Sampler"]

DEFAULT = RANDOM.name
GROWING = SOBOL.name  # what is proposed for sweeps that are to grow, and for correlated inputs
INDICES = SALTELLI.name  # what is proposed for Sobol' indices

for sampler in (RANDOM, LATIN_HYPERCUBE, SOBOL, HALTON, TABLE, SALTELLI, SALTELLI_SECOND, MORRIS, IMPORTANCE):
    SAMPLERS.add(sampler)
