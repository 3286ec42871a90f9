"""What of a model is not looked at by anything else, but named."""

import numpy as np

from lienumba.importing.mapping.draft import Draft
from lienumba.importing.mapping.flags import is_off
from lienumba.importing.mapping.source import Source

COUNTED = {  # not of the motion
    "nsensor": "sensors", "ncam": "cameras", "nlight": "lights", "nskin": "skins", "nhfield": "height fields",
}  # fmt: skip


def note_left_out(source: Source, draft: Draft) -> None:
    """Name what a scenario has nothing for."""
    m = source.model
    touching = (np.any(m.geom_contype) and np.any(m.geom_conaffinity) and m.ngeom > 1) or m.npair
    if touching and not is_off(m, "CONTACT"):
        draft.note("contact is left out")
    if m.nflex:
        draft.note("flexible bodies are left out")
    if m.nplugin:
        draft.note("plugins are left out")
    if m.nmocap:
        places = [source.place("body", int(b)) for b in np.flatnonzero(m.body_mocapid >= 0)]
        draft.note("mocap bodies stand still", *places, lost=False)
    for field, what in COUNTED.items():
        if count := getattr(m, field):
            draft.note(f"{what} are left out ({count})", lost=False)
