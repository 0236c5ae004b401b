"""Cues: what is seen, where the camera goes, and the notes of the score, for goldens."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import astuple, dataclass
from pathlib import Path
from typing import Any, Final

from audio.midi_file import NoteOn
from pipeline.errors import StoreError
from pipeline.production.goldens.golden_card import AGAIN
from pipeline.production.reports.stills import spread
from pipeline.simulation.take import Part
from render.shot import CameraPose

CAMERA: Final = 2e-3
"""Of the camera's place and of what it looks at [m]."""

ANGLE: Final = 0.02
"""Of its field of view [degrees]."""

_UP: Final = 2e-3
"""Of the direction that is up."""

MOST_POSES: Final = 240
"""Of a long film, so many are kept, spread evenly."""

_DIGITS: Final = 5
_FEW: Final = 6
"""Differences that are told one by one."""


@dataclass(frozen=True, slots=True)
class Cues:
    """What cameras and instruments do.

    Attributes:
        camera: frame -> place, what is looked at, up, field of view, as ten numbers.
        ticks: of the score, a frame; a fraction in words.
        notes: of the score.
        parts: visible solid -> its material, in the order of the take.
    """

    camera: dict[int, tuple[float, ...]]
    ticks: str
    notes: tuple[NoteOn, ...]
    parts: dict[str, str]

    def encoded(self) -> str:
        """Return them as JSON, a line for each pose and note."""
        poses = ",\n".join(f'  "{f}": {json.dumps(pose)}' for f, pose in self.camera.items())
        rows = (json.dumps(astuple(note), ensure_ascii=False) for note in self.notes)
        notes = ",\n".join(f"  {row}" for row in rows)
        ticks = json.dumps(self.ticks)
        parts = json.dumps(self.parts, indent=1, ensure_ascii=False)
        head = f'{{"ticks": {ticks},\n"parts": {parts},'
        return f'{head}\n"camera": {{\n{poses}\n}},\n"notes": [\n{notes}\n]}}\n'


def cues_of(
    poses: Sequence[CameraPose], ticks: str, notes: tuple[NoteOn, ...], parts: Sequence[Part]
) -> Cues:
    """Return the cues of a film whose camera stands at `poses`, by frame."""
    return Cues(
        {frame: _numbers(poses[frame - 1]) for frame in spread(len(poses), MOST_POSES)},
        ticks,
        notes,
        {part.name: part.material for part in parts},
    )


def _numbers(pose: CameraPose) -> tuple[float, ...]:
    numbers = (*pose.p_WC, *pose.p_WT, *pose.up, pose.fov_deg)
    return tuple(round(float(number), _DIGITS) for number in numbers)


def read_cues(path: Path) -> Cues:
    """Read cues.

    Raises:
        StoreError: they are damaged.
    """
    try:
        words: Any = json.loads(path.read_text(encoding="utf-8"))
        camera = {int(frame): tuple(map(float, pose)) for frame, pose in words["camera"].items()}
        notes = tuple(NoteOn(*row) for row in words["notes"])
        return Cues(camera, str(words["ticks"]), notes, dict(words["parts"]))
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise StoreError(f"{path}: the golden is damaged ({error}); {AGAIN}") from None


def differences(golden: Cues, new: Cues, exact: bool) -> Iterator[str]:
    """Give what differs, in words, the first first.

    Args:
        golden: what is to be.
        new: what is.
        exact: whether notes have to agree to the tick; elsewhere a cause may fall into the
            next frame.
    """
    yield from _of_parts(golden.parts, new.parts)
    yield from _of_cameras(golden.camera, new.camera)
    if golden.ticks != new.ticks:
        yield f"the score has {new.ticks} ticks a frame, the golden {golden.ticks}"
    elif exact:
        yield from _of_notes(golden.notes, new.notes)
    else:
        yield from _of_counts(golden.notes, new.notes)


def _of_parts(then: dict[str, str], now: dict[str, str]) -> Iterator[str]:
    for name in then | now:
        old, new = then.get(name), now.get(name)
        if old != new:
            told = "is gone" if new is None else f"is new, of {new}" if old is None else ""
            yield f"part {name} {told or f'is of {new}, in the golden of {old}'}"


def _of_cameras(
    then: dict[int, tuple[float, ...]], now: dict[int, tuple[float, ...]]
) -> Iterator[str]:
    bounds = (*(CAMERA,) * 6, *(_UP,) * 3, ANGLE)
    names = (*("stands",) * 3, *("looks",) * 3, *("is turned",) * 3, "sees")
    if then.keys() != now.keys():
        yield f"the camera has {len(now)} poses, the golden {len(then)}"
        return
    for frame, pose in then.items():
        apart = [abs(a - b) for a, b in zip(pose, now[frame], strict=True)]
        off = [k for k, amount in enumerate(apart) if amount > bounds[k]]
        if off:
            worst = max(off, key=lambda k: apart[k] / bounds[k])
            unit = "degrees" if worst == 9 else "of its up" if worst > 5 else "m"
            yield (
                f"the camera {names[worst]} otherwise from frame {frame} on, "
                f"by {apart[worst]:.4g} {unit}"
            )
            return


def _of_notes(then: Sequence[NoteOn], now: Sequence[NoteOn]) -> Iterator[str]:
    gone, new = Counter(then) - Counter(now), Counter(now) - Counter(then)
    pairs = [("is gone", note) for note in gone.elements()]
    pairs += [("is new", note) for note in new.elements()]
    pairs.sort(key=lambda pair: (pair[1], pair[0]))
    for fate, note in pairs[:_FEW]:
        yield (
            f"note {note.pitch} of {note.track!r} at tick {note.tick}, velocity "
            f"{note.velocity}: {fate}"
        )
    if len(pairs) > _FEW:
        yield f"and {len(pairs) - _FEW} more notes are gone or new"


def _of_counts(then: Sequence[NoteOn], now: Sequence[NoteOn]) -> Iterator[str]:
    counts = [Counter((note.track, note.pitch) for note in notes) for notes in (then, now)]
    for track, pitch in sorted(counts[0].keys() | counts[1].keys()):
        before, after = (count[track, pitch] for count in counts)
        if before != after:
            yield f"note {pitch} of {track!r} is played {after} times, in the golden {before}"
