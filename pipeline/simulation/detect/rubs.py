"""Rubs: bodies that roll or slide over the ground, heard for as long as they do.

From when on they do, their room says; see `rubbing`.

Source: Sims 1987, 13.1.2, sounds from motion.
"""

from __future__ import annotations

from pipeline.simulation.take import Contact


def rolls(contact: Contact) -> bool:
    """Tell whether a contact is that of a ball which rolls."""
    return contact.kind == "roll"


def slides(contact: Contact) -> bool:
    """Tell whether a contact is that of a body which slides."""
    return contact.kind == "slide"
