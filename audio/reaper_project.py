"""Reaper project: tracks of stems and scores, tempo, meter and markers as the text of a project.

Source: the text of projects that REAPER 7 writes; it reads what it misses as its default.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from fractions import Fraction
from pathlib import Path

from audio.performer_files import PerformerFile
from audio.score import Score
from audio.stems import Stem
from audio.tempo_plan import TempoPlan, tempo_plan

_VERSION = '0.1 "7.0/pronk" 0'
# Shape of a tempo that holds until the next.
_SQUARE = 1
_HAS_METER = 1


def reaper_project(
    score: Score, stems: Sequence[Stem], performers: Sequence[PerformerFile], folder: Path
) -> bytes:
    """Return the project of a score: a folder track of each performer, with its stems and MIDI.

    Args:
        score: its tempo, markers and length are used.
        stems: items of audio.
        performers: items of MIDI.
        folder: of the project; the files lie in it or below.
    """
    plan = tempo_plan(score)
    length = score.frames / score.rate
    lines = [f"<REAPER_PROJECT {_VERSION}", *_tempo_lines(plan, length)]
    lines += _marker_lines(score)
    causes: dict[str, list[Stem]] = defaultdict(list)
    for stem in stems:
        causes[stem.performer].append(stem)
    for performer in performers:
        own = causes[performer.performer]
        lines += _track_lines(performer.performer, bus="1 1")
        for stem in own:
            path = stem.path.relative_to(folder)
            lines += _track_lines(stem.cause, "0 0", ("WAVE", path, length))
        # The MIDI of a performer is silent until an instrument is chosen for its track.
        path = performer.path.relative_to(folder)
        lines += _track_lines(f"{performer.performer} MIDI", "2 -1", ("MIDI", path, length))
    for stem in causes[""]:
        path = stem.path.relative_to(folder)
        lines += _track_lines(stem.cause, "0 0", ("WAVE", path, length))
    return "\n".join([*lines, ">", ""]).encode("utf-8", "replace")


def _tempo_lines(plan: TempoPlan, length: Fraction) -> Iterator[str]:
    """Yield tempo and meter: exact ones, where the MIDI file has whole microseconds."""
    grid = plan.grid
    tempos = {span.tick: 60_000_000 / tempo for span, tempo in grid.span_tempos()}
    meters = {signature.tick: signature.meter for signature in grid.signatures}
    points = []
    tempo, meter = tempos[0], meters[0]
    for tick in sorted({*tempos, *meters}):
        tempo = tempos.get(tick, tempo)
        time = grid.seconds(tick)
        changed = tick in meters
        meter = meters.get(tick, meter)
        if time < length or tick == 0:
            code = f" {meter[0] + 65536 * meter[1]} 0 {_HAS_METER}" if changed else ""
            points.append(f"    PT {float(time):.12f} {float(tempo):.10f} {_SQUARE}{code}")
    first = meters[0]
    yield f"  TEMPO {float(tempos[0]):.10f} {first[0]} {first[1]}"
    yield "  <TEMPOENVEX"
    yield "    ACT 1 -1"
    yield from points
    yield "  >"


def _marker_lines(score: Score) -> Iterator[str]:
    for number, marker in enumerate(score.markers, start=1):
        time = float((marker.frame - 1) / score.rate)
        yield f"  MARKER {number} {time:.12f} {_quoted(marker.label)} 0"


def _track_lines(
    name: str, bus: str, source: tuple[str, Path, Fraction] | None = None
) -> Iterator[str]:
    """Yield a track.

    Args:
        name: of it.
        bus: place among folders: "1 1" opens one, "2 -1" is its last.
        source: kind, file and length [s] of its item.
    """
    yield "  <TRACK"
    yield f"    NAME {_quoted(name)}"
    yield f"    ISBUS {bus}"
    if source is not None:
        kind, path, length = source
        yield "    <ITEM"
        yield "      POSITION 0"
        yield f"      LENGTH {float(length):.12f}"
        yield "      LOOP 0"
        yield f"      NAME {_quoted(path.name)}"
        yield f"      <SOURCE {kind}"
        yield f"        FILE {_quoted(path.as_posix())}"
        yield "      >"
        yield "    >"
    yield "  >"


def _quoted(text: str) -> str:
    """Return a text in the quotation mark that it does not hold."""
    line = " ".join(text.split())
    mark = next((mark for mark in "\"'`" if mark not in line), None)
    return f"`{line.replace('`', chr(39))}`" if mark is None else f"{mark}{line}{mark}"
