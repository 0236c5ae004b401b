"""Cue facts: settings, visible parts, camera poses and notes of a film."""

from __future__ import annotations

import json
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import astuple, dataclass, field, replace
from fractions import Fraction
from pathlib import Path
from typing import Any, Final

from audio.midi_file import NoteOn
from pipeline.errors import StoreError
from pipeline.production.goldens.golden_card import RESTORE_HINT
from pipeline.production.goldens.look_facts import (
    Look,
    Shapes,
    look_differences,
    shape_differences,
    shapes_of,
)
from pipeline.production.reports.stills import spread
from pipeline.simulation.take import Take
from render.shot import CameraPose

CAMERA_TOLERANCE: Final = 2e-3
"""Of the camera's place and its target [m]."""

ANGLE_TOLERANCE: Final = 0.02
"""Of the field of view [degrees]."""

_UP_TOLERANCE: Final = 2e-3
"""Of the components of the up direction."""

MAX_POSES: Final = 240
"""Poses that are kept of a long film, spread evenly."""

VELOCITY_TOLERANCE: Final = 2
"""Of the velocities of notes where the motion has other bits."""

_LENS_TOLERANCE: Final = 1e-4
"""Of the radius of the lens [m]."""

_FOCUS_TOLERANCE: Final = 5e-3
"""Of the distance of the focus [m]."""

_LENS: Final = 10
"""Number of the radius of the lens in a pose; the focus follows."""

_DIGITS: Final = 5
_MAX_LISTED: Final = 6
"""Differences that are listed one by one."""


@dataclass(frozen=True, slots=True)
class Cues:
    """Settings, camera poses, notes and parts.

    Attributes:
        camera: frame -> place, target, up, field of view, radius of the lens and distance of its
            focus, as twelve numbers.
        ticks: per frame of the score, a fraction as text.
        notes: of the score.
        parts: visible solid -> its material, in the order of the take.
        look: settings of film, lights and materials; empty in goldens that were recorded without
            look and lens, and with less of the notes.
        shapes: of the parts.
    """

    camera: dict[int, tuple[float, ...]]
    ticks: str
    notes: tuple[NoteOn, ...]
    parts: dict[str, str]
    look: Look = field(default_factory=dict)
    shapes: Shapes = field(default_factory=dict)

    def encoded(self) -> str:
        """Return the cues as JSON, one line per pose and note."""
        poses = ",\n".join(f'  "{f}": {json.dumps(pose)}' for f, pose in self.camera.items())
        rows = (json.dumps(astuple(note), ensure_ascii=False) for note in self.notes)
        notes = ",\n".join(f"  {row}" for row in rows)
        ticks = json.dumps(self.ticks)
        parts = json.dumps(self.parts, indent=1, ensure_ascii=False)
        head = f'{{"ticks": {ticks},\n"parts": {parts},\n"look": {_lines(self.look)},'
        head += f'\n"shapes": {_lines(self.shapes)},'
        return f'{head}\n"camera": {{\n{poses}\n}},\n"notes": [\n{notes}\n]}}\n'


def _lines(values: Mapping[str, Any]) -> str:
    """Return a mapping as JSON, one line per item."""
    items = (
        f"  {json.dumps(name, ensure_ascii=False)}: {json.dumps(value, ensure_ascii=False)}"
        for name, value in values.items()
    )
    return "{\n" + ",\n".join(items) + "\n}"


def cues_of(
    poses: Sequence[CameraPose], ticks: str, notes: tuple[NoteOn, ...], take: Take, look: Look
) -> Cues:
    """Return the cues of a film with one camera pose per frame."""
    return Cues(
        {frame: _numbers(poses[frame - 1]) for frame in spread(len(poses), MAX_POSES)},
        ticks,
        notes,
        {part.name: part.material for part in take.parts},
        look,
        shapes_of(take),
    )


def _numbers(pose: CameraPose) -> tuple[float, ...]:
    lens = (0.0, 0.0) if pose.lens is None else (pose.lens.radius, pose.lens.focus)
    numbers = (*pose.p_WC, *pose.p_WT, *pose.up, pose.fov_deg, *lens)
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
        return Cues(
            camera,
            str(members["ticks"]),
            notes,
            dict(members["parts"]),
            dict(members.get("look", {})),
            {name: tuple(shape) for name, shape in members.get("shapes", {}).items()},
        )
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise StoreError(f"{path}: the golden is damaged ({error}); {RESTORE_HINT}") from None


def cue_differences(golden: Cues, new: Cues, exact: bool, crossing: bool = False) -> Iterator[str]:
    """Yield the differences of cues from their golden as text, in order of time.

    Args:
        golden: expected cues.
        new: present cues.
        exact: whether the motion has the golden's bits, so that notes have to agree in all.
        crossing: whether a cause fell into the next frame, so that notes may, too.
    """
    new = new if golden.look else _as_recorded(new)
    yield from look_differences(golden.look, new.look)
    yield from _part_differences(golden.parts, new.parts)
    yield from shape_differences(golden.shapes, new.shapes)
    yield from _camera_differences(golden.camera, new.camera)
    if golden.ticks != new.ticks:
        yield f"the score has {new.ticks} ticks a frame, the golden {golden.ticks}"
    elif exact:
        yield from _note_differences(golden.notes, new.notes)
    else:
        frame = Fraction(golden.ticks) if crossing else Fraction(0)
        yield from _moved_notes(golden.notes, new.notes, float(frame))


def _as_recorded(cues: Cues) -> Cues:
    """Return cues with no more than goldens of earlier versions hold."""
    notes = tuple(NoteOn(n.tick, n.track, n.channel, n.pitch, n.velocity) for n in cues.notes)
    camera = {frame: pose[:_LENS] for frame, pose in cues.camera.items()}
    return replace(cues, camera=camera, notes=notes, look={}, shapes={})


def _part_differences(then: dict[str, str], now: dict[str, str]) -> Iterator[str]:
    for name in then | now:
        old, new = then.get(name), now.get(name)
        if old != new:
            text = "is gone" if new is None else f"is new, of {new}" if old is None else ""
            yield f"part {name} {text or f'is of {new}, in the golden of {old}'}"


def _camera_differences(
    then: dict[int, tuple[float, ...]], now: dict[int, tuple[float, ...]]
) -> Iterator[str]:
    lens = (_LENS_TOLERANCE, _FOCUS_TOLERANCE)
    bounds = (*(CAMERA_TOLERANCE,) * 6, *(_UP_TOLERANCE,) * 3, ANGLE_TOLERANCE, *lens)
    names = (*("stands",) * 3, *("looks",) * 3, *("is turned",) * 3, "sees", "opens", "focuses")
    if then.keys() != now.keys():
        yield f"the camera has {len(now)} poses, the golden {len(then)}"
        return
    for frame, pose in then.items():
        apart = [abs(a - b) for a, b in zip(pose, now[frame], strict=True)]
        if len(apart) > _LENS and not (pose[_LENS] and now[frame][_LENS]):
            # A pinhole has no focus.
            del apart[_LENS + 1 :]
        off = [k for k, amount in enumerate(apart) if amount > bounds[k]]
        if off:
            worst = max(off, key=lambda k: apart[k] / bounds[k])
            unit = "degrees" if worst == 9 else "of its up" if 5 < worst < 9 else "m"
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
        yield f"{_note_text(note)}: {fate}"
    if len(pairs) > _MAX_LISTED:
        yield f"and {len(pairs) - _MAX_LISTED} more notes are gone or new"


def _note_text(note: NoteOn) -> str:
    text = f"note {note.pitch} of {note.track!r} at tick {note.tick}, velocity {note.velocity}"
    if note.ticks:
        text += f", of {note.ticks} ticks, program {note.program}, pan {note.pan}"
        text += f", reverb {note.send}"
    return text


def _moved_notes(then: Sequence[NoteOn], now: Sequence[NoteOn], most: float) -> Iterator[str]:
    """Yield the notes that are at another tick or of another velocity as text.

    Args:
        then: notes of the golden.
        now: of the score.
        most: by which a note may have moved [ticks].
    """
    groups: dict[tuple[str, int], tuple[list[NoteOn], list[NoteOn]]]
    groups = defaultdict(lambda: ([], []))
    for side, notes in enumerate((then, now)):
        for note in notes:
            groups[note.track, note.pitch][side].append(note)
    for (track, pitch), (old, new) in sorted(groups.items()):
        if len(old) != len(new):
            yield f"note {pitch} of {track!r} is played {len(new)} times, in the golden {len(old)}"
            continue
        for before, after in zip(old, new, strict=True):
            if abs(after.tick - before.tick) > most:
                yield f"{_note_text(before)}: moved to tick {after.tick}"
                break
            if abs(after.velocity - before.velocity) > VELOCITY_TOLERANCE:
                yield f"{_note_text(before)}: has velocity {after.velocity}"
                break
