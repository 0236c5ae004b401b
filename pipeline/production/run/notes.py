"""Notes: what a run tells the author of a scene that ran, such as a creature that stopped.

They come from the scene (an order after the end of the film), from the simulation, from the path
of the camera and from the pictures. The manifest lists all of them; a summary of a few lines stands
at the end of the run.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from typing import Any, Literal

from pipeline.errors import Problem, PronkError
from pipeline.simulation.clock import Clock
from pipeline.simulation.take import BeatRecord, Take, TakeNote
from pipeline.spec import Scene
from pipeline.spec.yaml_tree import MappingNode, ScalarNode
from pipeline.terminal_text import escaped_line

MAX_LINES = 10
"""Lines of a summary, of which the last may count the rest."""

MAX_SUBJECTS = 3
"""Parts that a line of a summary names."""

NUMBER = re.compile(r"-?\d+(\.\d+)?(e[-+]?\d+)?")
"""What notes of one kind may differ in and be told together."""

Source = Literal["scene", "simulation", "camera", "picture"]


@dataclass(frozen=True, slots=True)
class Note:
    """A message to the author.

    Attributes:
        kind: by which programs tell notes apart, such as "stopped" or "never_given".
        source: where it was found.
        part: performer, or part of one, that it is about.
        seconds: time in the film [s].
        frame: the first frame that shows it, None for what no frame shows.
        text: the reason.
        place: file and line in the scene, "" where there is none.
    """

    kind: str
    source: Source
    part: str
    seconds: float
    frame: int | None
    text: str
    place: str = ""

    @property
    def facts(self) -> dict[str, Any]:
        """Its members as JSON has them, without the empty place of most notes."""
        members = asdict(self)
        return members if self.place else {k: v for k, v in members.items() if k != "place"}

    @property
    def subject(self) -> str:
        """What it is about, with its line."""
        return f"{self.place}: {self.part}" if self.place else self.part


class NotesRefused(PronkError):
    """A run has notes, which `--strict` makes an error.

    Attributes:
        notes: all of them.
    """

    exit_code = 1

    def __init__(self, notes: Sequence[Note]) -> None:
        self.notes = tuple(notes)
        lines = [f"{counted_notes(len(notes))}, and --strict allows none", *summary(notes)]
        super().__init__("\n  ".join(lines))

    @property
    def facts(self) -> dict[str, object]:
        """Its notes."""
        return {"notes": [note.facts for note in self.notes]}


def place_of(scene: Scene, path: str) -> str:
    """Return file and line of a value of the scene, "" where its file does not give it."""
    found = scene.source_map.with_location(Problem(path, ""))
    return f"{found.file}:{found.line}" if found.line else found.file


_ALONE = (MappingNode, ScalarNode)
"""Nodes of one camera: its mapping, or the word `auto`."""


def cut_path(scene: Scene, number: int) -> str:
    """Return the path of a cut in the scene, such as `camera[1]`."""
    tree = scene.source_map.tree
    alone = isinstance(tree, MappingNode) and isinstance(tree.get("camera"), _ALONE)
    return "camera" if alone else f"camera[{number}]"


def refuse_notes(notes: Sequence[Note]) -> None:
    """Refuse all notes but advisory ones.

    Raises:
        NotesRefused: there are others.
    """
    if any(note.kind not in ADVISORY for note in notes):
        raise NotesRefused(notes)


def clock_of(scene: Scene) -> Clock:
    """Return the grid of a scene's steps and frames."""
    return Clock(scene.rate, scene.n_frames, scene.steps, scene.rows_per_frame)


ORDER_TEXTS = {
    "given up": "could not {text}: {reason}",
    "cut off": "has not finished {text} at the end of the film",
    "never given": "was never told {text}: {reason}",
}
"""Texts of notes on orders, by their outcome; other outcomes leave no note."""

BEAT_TEXTS = {
    "played": "the beat begins{choice}: {reason}; it ends {after}, {ending}",
    "cut off": "the beat begins{choice}: {reason}; the film ends before it",
    "never played": "the beat is never played: {reason}",
    "reached": "the goal is reached: {reason}",
    "never reached": "the goal is never reached: {reason}",
}
"""Texts of notes on beats and goals of the story, by their outcome."""

STORY_KINDS = tuple(f"story_{outcome.replace(' ', '_')}" for outcome in BEAT_TEXTS)

CUT_OFF = "order_cut_off"

ADVISORY = (CUT_OFF, *STORY_KINDS)
"""Kinds of notes that `--strict` allows: a film may end while somebody walks on, and a story has
beats that a seed leaves out."""


def take_notes(take: Take, clock: Clock) -> list[Note]:
    """Return the notes of a simulation and of its orders, in the order of time."""
    found = [(note.kind, note.step, note.part, note.text) for note in take.notes]
    for order in take.orders:
        if order.outcome in ORDER_TEXTS:
            text = ORDER_TEXTS[order.outcome].format(text=order.text, reason=order.reason)
            kind = f"order_{order.outcome.replace(' ', '_')}"
            found.append((kind, order.end, order.who, text))
    found += [
        (f"story_{beat.outcome.replace(' ', '_')}", beat.step, beat.name, _beat_text(beat, clock))
        for beat in take.beats
    ]
    return [_simulated(clock, *fields) for fields in sorted(found, key=lambda note: note[1])]


def _beat_text(beat: BeatRecord, clock: Clock) -> str:
    """Return what became of a beat, and why."""
    seconds = float(clock.time_of(beat.end) - clock.time_of(beat.step))
    return BEAT_TEXTS[beat.outcome].format(
        choice=f" by {beat.choice}" if beat.choice else "",
        reason=beat.reason,
        after=f"after {seconds:.1f} s",
        ending=beat.ending,
    )


def foreseen_notes(notes: Iterable[TakeNote], clock: Clock) -> list[Note]:
    """Return notes of rows that are yet to be simulated."""
    return [_simulated(clock, note.kind, note.step, note.part, note.text) for note in notes]


def _simulated(clock: Clock, kind: str, step: int, part: str, text: str) -> Note:
    seconds = round(float(clock.time_of(step)), 3)
    frame = min(clock.frame_of(step, 0.0), clock.frames)
    return Note(kind, "simulation", part, seconds, frame, text)


def read_notes(members: object) -> list[Note]:
    """Return the notes that a manifest lists; what is none is left out."""
    names = {field.name for field in fields(Note)}
    entries = members if isinstance(members, list) else []
    return [
        Note(**entry)
        for entry in entries
        if isinstance(entry, Mapping) and names - {"place"} <= entry.keys() <= names
    ]


def counted_notes(count: int) -> str:
    """Return a number of notes in words."""
    return "1 note" if count == 1 else f"{count} notes"


def summary(notes: Sequence[Note], rest: str = "") -> list[str]:
    """Return at most `MAX_LINES` lines on notes, equal ones together.

    Args:
        notes: in the order in which they are told.
        rest: where those stand that have no line.
    """
    groups = list(_groups(notes))
    if len(groups) <= MAX_LINES:
        return [escaped_line(_line(group)) for group in groups]
    shown = groups[: MAX_LINES - 1]
    left = len(notes) - sum(map(len, shown))
    last = f"and {left} more" + (f" in {rest}" if rest else "")
    return [escaped_line(line) for line in (*map(_line, shown), last)]


def _groups(notes: Iterable[Note]) -> Iterator[list[Note]]:
    """Yield the notes that differ only in part, numbers and time, in the order of the first.

    Orders that the end of the film cuts off are one group, whatever they are; each missed key is
    one of its own.
    """
    groups: dict[tuple[str, str, str], list[Note]] = {}
    for note in notes:
        text = "" if note.kind == CUT_OFF else NUMBER.sub("#", note.text)
        text = note.text if note.kind in ("missed_key", *STORY_KINDS) else text
        groups.setdefault((note.source, note.kind, text), []).append(note)
    yield from groups.values()


def _line(group: Sequence[Note]) -> str:
    subjects = list(dict.fromkeys(note.subject for note in group))
    named = ", ".join(subjects[:MAX_SUBJECTS])
    if len(subjects) > MAX_SUBJECTS:
        named += f" and {len(subjects) - MAX_SUBJECTS} more"
    first = group[0]
    if first.source == "scene":
        return f"{named}: {first.text}"
    moments = len({note.seconds for note in group})
    when = f"at {first.seconds:.1f} s" if moments == 1 else f"from {first.seconds:.1f} s on"
    times = f", {len(group)} times" if len(group) > len(subjects) else ""
    # Texts on orders, beats and pictures are sentences of their own.
    is_sentence = first.kind.startswith(("order_", "story_")) or first.source in (
        "camera",
        "picture",
    )
    verb = "" if is_sentence else f" {first.kind.replace('_', ' ')}"
    others = len({note.text for note in group}) - 1
    text = f"{first.text}, and {others} like it" if others else first.text
    return f"{named}{verb} {when}{times}: {text}"
