"""One model of MuJoCo, imported, against MuJoCo."""

import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from bench.importing import ours
from bench.importing.edits import without_lost
from bench.importing.pinocchio import aba
from bench.importing.reference import Reference, States
from bench.importing.starts import Starts
from lienumba.errors import ScenarioError
from lienumba.importing import from_file
from lienumba.importing.reading import read
from lienumba.scenario.resolve import resolve
from lienumba.scenario.start.prepare import check_initial

Array = np.ndarray
STATES = 100
GENTLE = 0.3  # of the random rates, at the start of a motion
LONGEST = 1e-3  # s, of a step of motions; where the importer says that a shorter one is stable, that one
FREELY, LOOPED = 40_000, 1000  # steps at most, without and with loops
SETTLED = 1e-4  # m: where MuJoCo's own error is larger, the next step is tried
SMALL = 1.0  # m/s^2, rad/s^2: errors of what accelerates less are not relative


@dataclass
class Row:
    """Of the table: error: the worst of accelerations, relative to the largest of the same state; refined: that against
    MuJoCo's without its rounding; moved, theirs: of the mass centres (m) within a while, ours against the finest of
    MuJoCo's, and MuJoCo's against its own at half the step; step, lasted (s): of that."""

    model: str
    kind: str
    links: int = 0
    coordinates: int = 0
    loops: int = 0
    seconds: float = np.nan
    error: float = np.nan
    refined: float = np.nan
    pinocchio: float = np.nan
    moved: float = np.nan
    theirs: float = np.nan
    step: float = np.nan
    lasted: float = np.nan
    lost: list[str] = field(default_factory=list)
    noted: list[str] = field(default_factory=list)
    refused: str = ""
    trouble: str = ""


class Pair:
    """A model, and what it was imported as."""

    def __init__(self, model: Any, imported: Any) -> None:
        self.model, self.lost = without_lost(model, imported.notes)
        self.reference = Reference(self.model)
        data = imported.to_dict()
        self.starts, self.step = Starts(data, self.reference, imported.notes), float(data["integrator"]["step"])

    def seen(self, states: States) -> tuple[ours.Seen, list[int]]:
        """What our bodies do, and which of them are the links."""
        found = ours.accelerations(self.starts.at(states), self.starts.columns(states))
        r, R = self.reference.centres(states)
        return found, ours.bodies_of_links(found, self.reference.masses, r, R)

    def error(self, states: States, a: Array, seen: ours.Seen, bodies: list[int]) -> float:
        """The worst error (see `Row`) where q'' = a is right."""
        linear, angular = self.reference.link_accelerations(states, a)
        here = np.concatenate([seen.linear[:, bodies], seen.angular[:, bodies]], axis=2)
        theirs = np.concatenate([linear, angular], axis=2)
        worst, largest = (np.abs(x[seen.fits]).max(axis=(1, 2)) for x in (here - theirs, theirs))
        return float((worst / np.maximum(largest, SMALL)).max(initial=0.0))

    def motion(self, state: States, bodies: list[int], step: float, lasting: float = 1.0) -> tuple[float, float]:
        """`moved` and `theirs` (see `Row`) of a motion from one state that lasts so long (s)."""
        times = lasting * np.arange(11) / 10
        coarse, fine = (self.reference.centres(self.reference.motion(state, h, times))[0] for h in (step, 0.5 * step))
        here = ours.motion(self.starts.at(state), 0.5 * step, times)[0][:, bodies]
        return float(np.abs(here - fine).max()), float(np.abs(coarse - fine).max())


def compare(path: Path, name: str, motions: bool = True) -> Iterator[Row]:
    """A file, read by lienumba's reader and compared: what is known of it after each part."""
    row = Row(name, "urdf" if path.suffix == ".urdf" else "mjcf")
    begin = time.process_time()
    try:
        imported = from_file(path)
    except ScenarioError as error:
        row.refused = str(error).replace(f"{path.parent}/", "")
        yield row
        return
    row.seconds = time.process_time() - begin
    row.noted = [note.what for note in imported.notes if not note.lost]
    try:
        for _ in _compared(row, imported, path, motions):
            yield row
    except Exception as error:  # whatever it is, it stands in the table
        row.trouble = f"{type(error).__name__}: {error}"
        yield row


def _compared(row: Row, imported: Any, path: Path, motions: bool) -> Iterator[None]:
    check_initial(resolve(imported.to_dict()))
    pair = Pair(read(path).model, imported)
    row.links, row.coordinates = len(pair.reference.links), int(pair.model.nv)
    row.loops, row.lost = int(pair.model.eq_active0.sum()), pair.lost
    states = pair.reference.random_states(STATES)
    seen, bodies = pair.seen(states)
    theirs = pair.reference.accelerations(states)
    row.error = pair.error(states, theirs, seen, bodies)
    if not row.loops and not pair.model.tendon_armature.any():
        row.refined = pair.error(states, pair.reference.refined(states, theirs), seen, bodies)
    if row.kind == "urdf" and not row.loops:
        row.pinocchio = pair.error(states, aba(path, pair.reference, states), seen, bodies)
    if not seen.fits.all():
        row.trouble = f"{np.count_nonzero(~seen.fits)} of {STATES} states are no starts"
    yield
    if motions:
        _add_motion(row, pair, states, bodies)
        yield


def _add_motion(row: Row, pair: Pair, states: States, bodies: list[int]) -> None:
    start = pair.reference.closed(states.q[0], GENTLE * states.v[0])
    assert start is not None
    state = States(start[0][None], start[1][None], GENTLE * states.ctrl[:1])
    trouble, longest = "", min(LONGEST, pair.step)
    most = LOOPED if row.loops else FREELY
    short = longest / 4
    tried = [(longest, _lasting(longest, most)), (short, _lasting(short, most)), (short, 0.1 * _lasting(short, most))]
    for step, lasted in tried:
        row.step, row.lasted = step, lasted
        try:
            row.moved, row.theirs = pair.motion(state, bodies, row.step, row.lasted)
        except (ValueError, np.linalg.LinAlgError) as error:
            trouble = f"motion: {error}"
            continue
        trouble = ""
        if row.theirs < SETTLED:
            break
    row.trouble = "; ".join(filter(None, [row.trouble, trouble]))


def _lasting(step: float, most: int) -> float:
    """How long (s) a motion of so many steps may be: 1, 0.1, ..."""
    return float(10.0 ** min(0.0, np.floor(np.log10(most * step) + 1e-9)))
