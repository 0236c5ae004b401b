"""Collisions: bodies that strike the terrain or one another.

What lies or rolls is silent: only what comes at more than the rest speed strikes.

Source: Sims 1987, 13.1.1.
"""

from __future__ import annotations

from pipeline.simulation.take import Contact


def collisions(contact: Contact) -> bool:
    """Tell whether a contact is that of something which strikes."""
    return contact.kind == "hit"
