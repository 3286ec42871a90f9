"""Random elements, drawn where the formulas change: beside 0, beside multiples of pi, and far out."""

import math

import numpy as np
from hypothesis import settings
from hypothesis import strategies as st

checked = settings(derandomize=True, max_examples=40)

component = st.floats(-5.0, 5.0).map(lambda x: 0.0 if abs(x) < 1e-100 else x)
vectors = st.tuples(component, component, component)


@st.composite
def directions(draw: st.DrawFn) -> np.ndarray:
    """A unit vector; often along an axis or in a plane of two."""
    v = np.array(draw(st.tuples(*[st.sampled_from([0.0, 1.0, -1.0, 0.3]) | st.floats(-1.0, 1.0)] * 3)))
    length = math.sqrt(v @ v)
    return v / length if length > 1e-3 else np.array([0.0, 0.0, 1.0])


tiny = st.floats(-300.0, -1.0).map(lambda e: 10.0**e)
turns = st.integers(0, 4)


def angles(largest: float = 30.0) -> st.SearchStrategy[float]:
    """An angle of at least 0: anywhere, tiny, or a hair beside a multiple of pi."""
    beside = st.builds(lambda n, e, sign: abs(n * math.pi + sign * e), turns, tiny, st.sampled_from([-1.0, 0.0, 1.0]))
    return (st.floats(0.0, largest) | tiny | beside).filter(lambda angle: angle <= largest)


def rotation_vectors(largest: float = 30.0) -> st.SearchStrategy[tuple[float, float, float]]:
    return st.builds(lambda angle, axis: tuple((angle * axis).tolist()), angles(largest), directions())


def twists(largest: float = 30.0) -> st.SearchStrategy[tuple[float, ...]]:
    """Of se(3): translation, rotation."""
    return st.builds(lambda p, u: (*p, *u), vectors, rotation_vectors(largest))
