"""Cue facts: visible parts, camera poses and notes of a film."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import astuple, dataclass
from pathlib import Path
from typing import Any, Final

from audio.midi_file import NoteOn
from pipeline.errors import StoreError
from pipeline.production.goldens.golden_card import RESTORE_HINT
from pipeline.production.reports.stills import spread
from pipeline.simulation.take import Part
from render.shot import CameraPose

CAMERA_TOLERANCE: Final = 2e-3
"""Of the camera's place and its target [m]."""

ANGLE_TOLERANCE: Final = 0.02
"""Of the field of view [degrees]."""

_UP_TOLERANCE: Final = 2e-3
"""Of the components of the up direction."""

MAX_POSES: Final = 240
"""Poses that are kept of a long film, spread evenly."""

_DIGITS: Final = 5
_MAX_LISTED: Final = 6
"""Differences that are listed one by one."""


@dataclass(frozen=True, slots=True)
class Cues:
    """Camera poses, notes and parts.

    Attributes:
        camera: frame -> place, target, up and field of view, as ten numbers.
        ticks: per frame of the score, a fraction as text.
        notes: of the score.
        parts: visible solid -> its material, in the order of the take.
    """

    camera: dict[int, tuple[float, ...]]
    ticks: str
    notes: tuple[NoteOn, ...]
    parts: dict[str, str]

    def encoded(self) -> str:
        """Return the cues as JSON, one line per pose and note."""
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
    """Return the cues of a film with one camera pose per frame."""
    return Cues(
        {frame: _numbers(poses[frame - 1]) for frame in spread(len(poses), MAX_POSES)},
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
        StoreError: the file is damaged.
    """
    try:
        members: Any = json.loads(path.read_text(encoding="utf-8"))
        camera = {int(frame): tuple(map(float, pose)) for frame, pose in members["camera"].items()}
        notes = tuple(NoteOn(*row) for row in members["notes"])
        return Cues(camera, str(members["ticks"]), notes, dict(members["parts"]))
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise StoreError(f"{path}: the golden is damaged ({error}); {RESTORE_HINT}") from None


def cue_differences(golden: Cues, new: Cues, exact: bool) -> Iterator[str]:
    """Yield the differences of cues from their golden as text, in order of time.

    Args:
        golden: expected cues.
        new: present cues.
        exact: whether notes have to agree to the tick; on other machines a cause can fall into
            the next frame.
    """
    yield from _part_differences(golden.parts, new.parts)
    yield from _camera_differences(golden.camera, new.camera)
    if golden.ticks != new.ticks:
        yield f"the score has {new.ticks} ticks a frame, the golden {golden.ticks}"
    elif exact:
        yield from _note_differences(golden.notes, new.notes)
    else:
        yield from _count_differences(golden.notes, new.notes)


def _part_differences(then: dict[str, str], now: dict[str, str]) -> Iterator[str]:
    for name in then | now:
        old, new = then.get(name), now.get(name)
        if old != new:
            text = "is gone" if new is None else f"is new, of {new}" if old is None else ""
            yield f"part {name} {text or f'is of {new}, in the golden of {old}'}"


def _camera_differences(
    then: dict[int, tuple[float, ...]], now: dict[int, tuple[float, ...]]
) -> Iterator[str]:
    bounds = (*(CAMERA_TOLERANCE,) * 6, *(_UP_TOLERANCE,) * 3, ANGLE_TOLERANCE)
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


def _note_differences(then: Sequence[NoteOn], now: Sequence[NoteOn]) -> Iterator[str]:
    gone, new = Counter(then) - Counter(now), Counter(now) - Counter(then)
    pairs = [("is gone", note) for note in gone.elements()]
    pairs += [("is new", note) for note in new.elements()]
    pairs.sort(key=lambda pair: (pair[1], pair[0]))
    for fate, note in pairs[:_MAX_LISTED]:
        yield (
            f"note {note.pitch} of {note.track!r} at tick {note.tick}, velocity "
            f"{note.velocity}: {fate}"
        )
    if len(pairs) > _MAX_LISTED:
        yield f"and {len(pairs) - _MAX_LISTED} more notes are gone or new"


def _count_differences(then: Sequence[NoteOn], now: Sequence[NoteOn]) -> Iterator[str]:
    counts = [Counter((note.track, note.pitch) for note in notes) for notes in (then, now)]
    for track, pitch in sorted(counts[0].keys() | counts[1].keys()):
        before, after = (count[track, pitch] for count in counts)
        if before != after:
            yield f"note {pitch} of {track!r} is played {after} times, in the golden {before}"
