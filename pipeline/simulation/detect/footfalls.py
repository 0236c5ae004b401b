"""Footfalls: feet that come down on the terrain.

Source: Sims 1987, 13.1.1.
"""

from __future__ import annotations

from pipeline.simulation.take import Contact


def footfalls(contact: Contact) -> bool:
    """Tell whether a contact is that of a foot which comes down."""
    return contact.kind == "touch" and contact.other == "terrain"
