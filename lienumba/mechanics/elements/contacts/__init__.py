"""Contacts: one class for each type, with its keys and its geometry. `CONTACTS` knows them by name."""

from lienumba.mechanics.elements.contacts import types, yielding
from lienumba.mechanics.elements.contacts.base import CONTACTS, ContactType
from lienumba.mechanics.elements.contacts.geometry import Place

__all__ = ["CONTACTS", "ContactType", "Place", "types", "yielding"]
