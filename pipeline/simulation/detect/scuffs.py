"""Scuffs: feet that drag over the terrain.

Whether a foot is low and quick enough to be heard, its walking says; see `scuffing`.

Source: Sims 1987, 13.1.2, sounds from motion.
"""

from __future__ import annotations

from pipeline.simulation.take import Contact


def scuffs(contact: Contact) -> bool:
    """Tell whether a contact is that of a foot which scuffs over the terrain."""
    return contact.kind == "scuff" and contact.other == "terrain"
