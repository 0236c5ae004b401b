"""Sounding parts: the rigid parts of a take that its sound events tell of."""

from __future__ import annotations

from pipeline.simulation.sound_detection.sound_sources import RigidPart, rigid_parts
from pipeline.simulation.take import SoundEvent, Take

__all__ = ["RigidPart", "SoundingParts"]


class SoundingParts:
    """Finds the parts of events by name."""

    def __init__(self, take: Take) -> None:
        parts = rigid_parts(take.parts, take.meshes)
        self._parts = {take.nodes[node].name: part for node, part in parts.items()}
        # The last link of each limb, with which it touches.
        self._last_links: dict[str, tuple[int, str]] = {}
        for name in self._parts:
            limb, _, link = name.rpartition(".")
            if link.isdecimal() and int(link) >= self._last_links.get(limb, (-1, ""))[0]:
                self._last_links[limb] = int(link), name

    def striking(self, event: SoundEvent) -> RigidPart | None:
        """Return the part that touches, of a limb its last link; None if it is not rigid."""
        return self._named(f"{event.who}.{event.part}", event.part, event.who)

    def struck(self, event: SoundEvent) -> RigidPart | None:
        """Return the part that is touched; None for the ground and what is not rigid."""
        return self._named(event.other)

    def _named(self, *names: str) -> RigidPart | None:
        for name in names:
            _, last = self._last_links.get(name, (0, ""))
            part = self._parts.get(name) or self._parts.get(last)
            if part is not None:
                return part
        return None
