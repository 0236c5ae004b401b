"""Sound report: facts about MIDI and WAV for the manifest, and their summaries for the terminal."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

from audio.midi_file import MidiReport, PlayedPart
from audio.quantisation import TimingShifts
from audio.score import Score
from audio.tempo_report import TempoReport
from audio.wav_file import WavReport


def midi_facts(midi: MidiReport, subframe: bool, rate: Fraction) -> dict[str, Any]:
    """Return the manifest entry of the MIDI file, such as which events share a note."""
    return {
        "notes": midi.notes,
        "muted": midi.muted,
        "added_by_chords_and_phrases": midi.added,
        **({"of_the_music": midi.music} if midi.music else {}),
        "left_out_after_the_last_frame": midi.after_the_end,
        "merged": len(midi.losses.merged),
        "merged_by_frame": {str(frame): count for frame, count in midi.merged_by_frame.items()},
        "cut_short": midi.losses.cut_short,
        "without_their_gesture": midi.losses.without_curve,
        "parts": [_part_facts(played) for played in midi.parts],
        "subframe": subframe,
        "tempo": _tempo_facts(midi.tempo),
        **({"quantised": _quantisation_facts(midi.shifts, rate)} if midi.shifts.events else {}),
    }


def _part_facts(played: PlayedPart) -> dict[str, Any]:
    part, losses = played.part, played.losses
    return {
        "track": part.key.track,
        "performer": part.key.performer,
        "instrument": part.key.instrument,
        "port": part.port + 1,
        "channel": part.channel + 1,
        "notes": len(played.notes),
        "merged": len(losses.merged),
        "cut_short": losses.cut_short,
        "without_their_gesture": losses.without_curve,
    }


def _tempo_facts(tempo: TempoReport) -> dict[str, Any]:
    share = tempo.on_grid
    return {
        "bpm": round(float(tempo.bpm), 6),
        "from": tempo.source,
        "meter": tempo.meter,
        "first_bar_s": round(float(tempo.first_bar), 6),
        "ticks_per_beat": tempo.ticks_per_beat,
        "ticks_per_frame": round(float(tempo.ticks_per_frame), 6),
        "tempo_events": tempo.changes,
        "greatest_time_error_us": round(float(1_000_000 * tempo.frame_error), 3),
        "beat_error_at_the_end_us": round(float(1_000_000 * tempo.beat_error), 3),
        **({} if share is None else {f"share_of_notes_on_{tempo.grid}": round(share, 4)}),
        **({"notes_in_passing": tempo.passing} if tempo.passing else {}),
    }


def _quantisation_facts(shifts: TimingShifts, rate: Fraction) -> dict[str, Any]:
    return {
        "events": shifts.events,
        "moved": shifts.moved,
        "before_their_cause_is_shown": shifts.earlier,
        "mean_ms": round(float(1000 * shifts.mean), 3),
        "greatest_ms": round(float(1000 * shifts.greatest), 3),
        "mean_frames": round(float(shifts.mean * rate), 3),
        "greatest_frames": round(float(shifts.greatest * rate), 3),
    }


def quantisation_summary(shifts: TimingShifts, score: Score) -> str | None:
    """Return one line about the quantisation; None if the scene has none."""
    config = score.sound.quantise
    if config is None:
        return None
    grid = f"{config.grid} at {score.sound.beats_per_minute:g} beats a minute"
    if not shifts.moved:
        return f"score: all of {shifts.events} events stand on {grid} by themselves"
    mean, greatest = (1000 * float(by) for by in (shifts.mean, shifts.greatest))
    frames = float(shifts.greatest * score.rate)
    return (
        f"score: {shifts.moved} of {shifts.events} events moved to {grid}: by {mean:.0f} ms on "
        f"average, {greatest:.0f} ms ({frames:.1f} frames) at most; {shifts.earlier} sound earlier "
        "than they are seen"
    )


def wav_facts(wav: WavReport) -> dict[str, Any]:
    """Return the manifest entry of the WAV file; levels of silence are null."""
    return {
        "samples": wav.samples,
        "lufs": _finite(wav.lufs),
        "target_lufs": _finite(wav.target),
        "true_peak_db": _finite(wav.true_peak_db),
        "peak_db": _finite(wav.peak_db),
        "gain_db": _finite(wav.gain_db),
        "limited_db": _finite(wav.limited_db),
    }


def _finite(decibels: float) -> float | None:
    return round(decibels, 2) if math.isfinite(decibels) else None


def asked_loudness(score: Score) -> float:
    """Return the loudness that a score asks for [LUFS], -inf for none."""
    master = score.sound.master
    return -math.inf if master is None else master.lufs + score.sound.volume_db


TOLD_LU = 0.3
"""By how much a track is below the loudness that was asked for when it is told [LU]."""


def loudness_summary(wav: WavReport, asked: float) -> str:
    """Return loudness and true peak of a track in words, and whether it is less than asked for.

    Args:
        wav: of the track.
        asked: loudness that its scene asks for [LUFS]; -inf for none.
    """
    if wav.peak_db == -math.inf:
        return "silent"
    peak = f"true peak {wav.true_peak_db:.1f} dB"
    if wav.lufs == -math.inf:
        return peak
    if not wav.events and not wav.music:
        return f"ambience alone, {wav.lufs:.1f} LUFS"
    low = ""
    if asked - wav.lufs > TOLD_LU:
        reason = "to keep its peaks" if wav.limited_db > 0 else "with the greatest gain"
        low = f" instead of {asked:.1f}, {reason}"
    return f"loud {wav.lufs:.1f} LUFS{low}, {peak}"
