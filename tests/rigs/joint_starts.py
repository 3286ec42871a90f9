"""What a joint says of its start, with what is known of its coordinates by keyword."""

from dataclasses import fields, replace
from typing import Any

from lienumba.mechanics.mechanism.model import JointStart

PLACED = {field.name for field in fields(JointStart)}


def joint_start(**keys: Any) -> JointStart:
    return with_known(JointStart(**{key: x for key, x in keys.items() if key in PLACED}), **keys)


def with_known(says: JointStart, **keys: Any) -> JointStart:
    """Also with other places; None: not known."""
    placed = {key: x for key, x in keys.items() if key in PLACED}
    known = says.known | {key: x for key, x in keys.items() if key not in PLACED}
    return replace(says, **placed, known={key: x for key, x in known.items() if x is not None})
