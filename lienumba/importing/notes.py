"""What an imported scenario has otherwise than its source, or lacks: nothing is dropped in silence."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Note:
    """One thing that the scenario has otherwise, or lacks.

    Attributes
    ----------
    what : str
        What it is, and what became of it.
    places : tuple of str
        Where it stands in the source, by its names there: `joint "elbow"`; () for the whole model.
    lost : bool
        Whether the motion is another one than in the source; `strict` refuses then.
    """

    what: str
    places: tuple[str, ...] = ()
    lost: bool = True


def gathered(notes: list[Note]) -> list[Note]:
    """One note for each thing, with all of its places, in the order in which they came.

    Parameters
    ----------
    notes : list of Note
        As they were made.

    Returns
    -------
    list of Note
        None of which says what another one says.
    """
    places: dict[tuple[str, bool], dict[str, None]] = {}
    for note in notes:
        places.setdefault((note.what, note.lost), {}).update(dict.fromkeys(note.places))
    return [Note(what, tuple(where), lost) for (what, lost), where in places.items()]
