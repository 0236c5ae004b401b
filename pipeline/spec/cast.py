"""Cast: who is in a scene, where they start and what they do."""

from __future__ import annotations

from collections.abc import Sequence

from pydantic import Field

from pipeline.spec.values import Length, Name, Number, Point, Words
from pipeline.spec.walk import Walk


class Member(Words):
    """One member of the cast."""

    name: Name = Field(
        "", description="What it is called; after its figure if left out.", validate_default=False
    )
    figure: Name = Field(
        description="Its figure: from this file, from a file of that name beside it or in "
        "figures/ beside it, or from the shipped library."
    )
    at: Point = Field((0.0, 0.0), description="Where it starts, [x, z] on the ground [m].")
    heading_deg: Number = Field(
        0.0,
        ge=-3600,
        le=3600,
        description="Where it looks: 0 along +X, positive turns about +Y [degrees].",
    )
    scale: Length = Field(1.0, description="Factor on all lengths of the figure.")
    material: Name | None = Field(
        None, description="Material of all its parts that name none, by name."
    )
    walk: Walk | None = Field(None, description="How it walks; it stands still if left out.")


def names_of(cast: Sequence[tuple[str, str]]) -> list[str]:
    """Return the names of a cast, given each member's own name (or "") and its figure.

    A member without a name is called after its figure, and numbered from the second on: the
    first keeps its name (and so its random numbers) when another is added.
    """
    taken = {name for name, _ in cast if name}
    last: dict[str, int] = {}
    names = []
    for own, figure in cast:
        name, number = own or figure, last.get(figure, 1)
        while not own and name in taken:
            number += 1
            name = f"{figure}_{number}"
        if not own:
            last[figure] = number
        taken.add(name)
        names.append(name)
    return names
