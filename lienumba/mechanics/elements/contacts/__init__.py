"""Contacts: one class for each type, with its keys and its geometry. `CONTACTS` knows them by name."""

from lienumba.mechanics.elements.contacts import compliant, types
from lienumba.mechanics.elements.contacts.base import CONTACTS, ContactType
from lienumba.mechanics.elements.contacts.geometry import Place

__all__ = ["CONTACTS", "ContactType", "Place", "compliant", "types"]
