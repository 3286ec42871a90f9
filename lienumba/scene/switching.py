"""What holds, is open or closed in a run of a mechanism that changes, when, and where one sees it."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from lienumba.integrators.codes import IMPACT
from lienumba.mechanics.mechanism.kinematics import OFF, STICK
from lienumba.mechanics.system.switches import CONTACT, FRICTION, JOINT, LIMIT, LOCK
from lienumba.scene.mechanism import Mechanism, Place

if TYPE_CHECKING:
    import xarray as xr

# How a switched constraint looks, by its index; 0: as if nothing could change.
PLAIN, LOCKED, OPEN, CLOSED, STICKING = range(5)
LOOKS = {LOCKED: "locked", OPEN: "open", CLOSED: "closed", STICKING: "sticks"}


@dataclass(frozen=True)
class Switching:
    """The switched constraints of a run that have a place.

    Attributes
    ----------
    names : tuple of str
        What each is called.
    places : tuple of Place
        Where each is.
    times : numpy.ndarray
        (T,) in s.
    looks : numpy.ndarray
        (T, switches): how each looks from each of these times on.
    hits : tuple of (float, int)
        When (s) one was hit, and which.
    """

    names: tuple[str, ...]
    places: tuple[Place, ...]
    times: np.ndarray
    looks: np.ndarray
    hits: tuple[tuple[float, int], ...]

    def at(self, times: np.ndarray) -> np.ndarray:
        """How each looks (n, switches) at times (n,) in s."""
        found: np.ndarray = self.looks[np.searchsorted(self.times, times, side="right").clip(1) - 1]
        return found

    def hit(self, times: np.ndarray, span: float) -> np.ndarray:
        """Which was hit (n, switches) up to a span (s) before times (n,) in s."""
        found = np.zeros((len(times), len(self.names)), bool)
        for time, n in self.hits:
            found[:, n] |= (times >= time) & (times < time + span)
        return found


def switching(there: "xr.Dataset", mechanism: Mechanism) -> Switching | None:
    """That of the one run of a dataset, if its mechanism changes and its modes are stored over time."""
    if "mode" not in there or there["mode"].dims != ("run", "time", "switch"):
        return None
    every = [(n, str(name), _found(str(name), mechanism.switched)) for n, name in enumerate(there["switch"].values)]
    seen = [(n, name, key) for n, name, key in every if key is not None]
    modes = np.nan_to_num(there["mode"].values[0]).astype(int)
    looks = np.zeros((len(modes), len(seen)), np.int8)
    for column, (n, _, (what, _)) in enumerate(seen):
        looks[:, column] = [_look(what, mode) for mode in modes[:, n]]
    columns = {n: column for column, (n, *_) in enumerate(seen)}
    places = tuple(mechanism.switched[key] for *_, key in seen)
    return Switching(tuple(x for _, x, _ in seen), places, there["time"].values, looks, tuple(_hits(there, columns)))


def _found(name: str, switched: Mapping[tuple[str, str], Place]) -> tuple[str, str] | None:
    """The key of a switch by its name in the dataset, which says what it is where several have that name."""
    return next((key for key in switched if name in (key[1], f"{key[1]} ({key[0]})")), None)


def _look(what: str, mode: int) -> int:
    if what == JOINT:
        return OPEN if mode == OFF else PLAIN
    if mode == OFF or (what == FRICTION and mode != STICK):
        return PLAIN
    return {LOCK: LOCKED, LIMIT: CLOSED, CONTACT: CLOSED, FRICTION: STICKING}[what]


def _hits(there: "xr.Dataset", columns: Mapping[int, int]) -> list[tuple[float, int]]:
    """The impacts on what has a place."""
    if "change_kind" not in there:
        return []
    kinds, whats, times = (there[f"change_{name}"].values[0] for name in ("kind", "what", "time"))
    hits = np.flatnonzero(kinds == IMPACT)
    return [(float(times[k]), columns[int(whats[k])]) for k in hits if int(whats[k]) in columns]
