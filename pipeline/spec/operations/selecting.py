"""Select: the set that later operations work on.

Source: Sims 1987, A.1 (select all, unselect all, a previously selected set, a circled set).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Annotated, Any, Literal

from pydantic import Discriminator, Field, Tag

from pipeline.spec.faults import Fault
from pipeline.spec.operations.chosen import Names, chosen
from pipeline.spec.operations.enclosure import encloses
from pipeline.spec.operations.sheet import At, Sheet
from pipeline.spec.values import Point, Words

Outline = Annotated[tuple[Point, ...], Field(min_length=3, max_length=1000)]


def _form(words: Any) -> str:
    if isinstance(words, str):
        return "by a word"
    is_outline = isinstance(words, Sequence) and words and not isinstance(words[0], str)
    return "by an outline" if is_outline else "by name"


class Select(Words):
    """Chooses the nodes that later operations call `selected`."""

    select: Annotated[
        Annotated[Names, Tag("by name")]
        | Annotated[Outline, Tag("by an outline")]
        | Annotated[Literal["all", "none", "previous"], Tag("by a word")],
        Discriminator(_form),
    ] = Field(
        description="Names; an outline [[x, y], ...] around the nodes; all; none; or previous, "
        "the set that was selected before the present one."
    )


def select(words: Select, sheet: Sheet) -> tuple[Sheet, list[Fault]]:
    """Return the sheet with another selection, and what is wrong with the words."""
    match words.select:
        case "none":
            return replace(sheet, present=-1), []
        case "previous":
            return _previous(sheet)
        case str():
            return _selected(sheet, tuple(sheet.marks)), []
        case (str(), *_):
            names = tuple(name for name in words.select if isinstance(name, str))
            picked, faults = chosen(names, sheet, ("select",))
            return _selected(sheet, tuple(name for name, _ in picked)), faults
    outline: list[At] = [at for at in words.select if not isinstance(at, str)]
    inside = tuple(name for name, mark in sheet.marks.items() if encloses(outline, mark.at))
    faults = [] if inside else [Fault(("select",), "there is no node inside this outline")]
    return _selected(sheet, inside), faults


def _previous(sheet: Sheet) -> tuple[Sheet, list[Fault]]:
    """Go back by one in the ring of the sets that were selected."""
    if not sheet.sets:
        return sheet, [Fault(("select",), "nothing was selected before")]
    # What was unselected is the latest of them.
    before = sheet.present - 1 if sheet.present >= 0 else len(sheet.sets) - 1
    return replace(sheet, present=before % len(sheet.sets)), []


def _selected(sheet: Sheet, names: tuple[str, ...]) -> Sheet:
    sets = (*sheet.sets, names)
    return replace(sheet, sets=sets, present=len(sets) - 1)
