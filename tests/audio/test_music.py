"""Music of a score: sections, chords and generated pieces as notes on beats."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from audio.config.sound import Sound
from audio.errors import ScoreError
from audio.midi_file import midi_bytes, write_midi
from audio.music.scene_course import SceneCourse
from audio.notes import Note, notes_of
from audio.score import DanceBeat
from audio.tempo_plan import tempo_plan

KIT: dict[str, Any] = {"kit": {}}


def music(line: Any, chords: str | None = None, **part: Any) -> dict[str, Any]:
    """Return the sound of one part that plays a line at 120 beats a minute."""
    section = {"play": {"lead": line}, **({"chords": chords} if chords else {})}
    parts = {"lead": {"instrument": "flute", "gate": 1, **part}}
    return {
        "tempo_bpm": 120,
        "scale": "A minor",
        "music": {"parts": parts, "sections": {"a": section}},
    }


def played(score: Any) -> list[Note]:
    """Return the notes of the music in the order of time."""
    return sorted((n for n in notes_of(score) if n.is_music), key=lambda n: (n.onset, n.pitch))


def line_of(score_of: Any, line: Any, chords: str | None = None, **part: Any) -> list[Any]:
    """Return beat, length in beats and pitch of the notes of one bar."""
    notes = played(score_of(sound=music(line, chords, **part), frames=48))
    return [(str(note.onset * 2), note.seconds * 2, note.pitch) for note in notes]


def test_notes_and_degrees_of_the_scale(score_of: Any) -> None:
    assert line_of(score_of, "C4 A3 0 -1") == [
        *(("0", 1.0, 60), ("1", 1.0, 57), ("2", 1.0, 69), ("3", 1.0, 67))
    ]
    assert [pitch for *_, pitch in line_of(score_of, "C4 2", octave=-1)] == [48, 60]


def test_holds_lengthen_and_accents_are_louder(score_of: Any) -> None:
    assert line_of(score_of, "C4 _ _ E4") == [("0", 3.0, 60), ("3", 1.0, 64)]
    soft, loud = played(score_of(sound=music("C4 E4^"), frames=48))
    assert loud.level > soft.level + 2


def test_tones_rhythms_and_arpeggios_play_the_chords(score_of: Any) -> None:
    assert [p for *_, p in line_of(score_of, {"tones": "0 1 2 3"}, "Am")] == [57, 60, 64, 69]
    chord = line_of(score_of, {"rhythm": "x..."}, "F")
    assert sorted(pitch % 12 for *_, pitch in chord) == [0, 5, 9]
    assert max(p for *_, p in chord) - min(p for *_, p in chord) < 12
    arpeggio = line_of(score_of, {"arpeggio": "up down", "step": "1/4"}, "C")
    assert [pitch for *_, pitch in arpeggio] == [60, 64, 67, 64]


def test_numerals_are_chords_of_the_scale(score_of: Any) -> None:
    pitches = [p % 12 for *_, p in line_of(score_of, {"tones": "[0 1 2]!4"}, "i iv VI V7")]
    # A minor, D minor, F major and, for it is in capitals, E major.
    assert pitches == [9, 0, 4, 2, 5, 9, 5, 9, 0, 4, 8, 11]


def test_sections_follow_the_form_and_loop(score_of: Any) -> None:
    sound = music("C4")
    sound["music"]["sections"]["b"] = {"bars": 2, "play": {"lead": "E4 G4"}}
    sound["music"]["form"] = ["a x2", "b"]
    found = [note.pitch for note in played(score_of(sound=sound, frames=48 * 5))]
    assert found == [60, 60, 64, 67, 64, 67, 60]
    sound["music"]["loop"] = False
    assert len(played(score_of(sound=sound, frames=48 * 5))) == 6


def test_drums_have_their_keys_and_channel(score_of: Any, read_smf: Any, check_laws: Any) -> None:
    sound = music("C4")
    sound["music"]["parts"] = KIT
    drums = {"bass drum": "x...", "closed hi-hat": "x(3,8)"}
    sound["music"]["sections"]["a"]["play"] = {"kit": {"drums": drums}}
    smf = read_smf(midi_bytes(score_of(sound=sound, frames=48)))
    check_laws(smf, 48, 24, drums=True)
    beat = smf.division
    assert [(tick, channel, key) for tick, channel, key, _ in smf.onsets()] == [
        *((0, 9, 36), (0, 9, 42), (3 * beat // 2, 9, 42), (3 * beat, 9, 42))
    ]


@pytest.mark.parametrize("rate", ["24", "25", "30000/1001", "60"])
def test_music_is_on_the_ticks_of_its_beats_beside_events(
    rate: str, step: Any, score_of: Any, read_smf: Any, check_laws: Any, tmp_path: Any
) -> None:
    sound = {**music("C4*16"), "tempo_bpm": 103}
    events = [step(frame) for frame in (30, 47, 66)]
    dance = DanceBeat(Fraction(103), Fraction(1))
    score = score_of(events, sound=sound, frames=240, rate=Fraction(rate), dance=dance)
    silent = score_of(events, sound={"tempo_bpm": 103, "scale": "A minor"}, frames=240,
                      rate=Fraction(rate), dance=dance)  # fmt: skip
    report = write_midi(score, tmp_path / "a.mid")
    smf = read_smf((tmp_path / "a.mid").read_bytes())
    check_laws(smf, 240, Fraction(rate))
    grid = tempo_plan(score).grid
    channels = {part.part.key.performer: part.part.channel for part in report.parts}
    of_music = [tick for tick, channel, *_ in smf.onsets() if channel == channels["music lead"]]
    assert of_music[0] == grid.bar_line
    # Beats are whole ticks at all rates; their sixteenths are the nearest where none is exact.
    for number, tick in enumerate(of_music):
        off = abs(tick - grid.bar_line - Fraction(number * smf.division, 4))
        assert off <= (Fraction(1, 2) if number % 4 else 0)
    # What performers play is untouched.
    others = [note for note in smf.onsets() if note[1] == channels["bug"]]
    alone = read_smf(midi_bytes(silent)).onsets()
    assert [(tick, *rest) for tick, _, *rest in others] == [(t, *rest) for t, _, *rest in alone]
    assert report.music == len(of_music)
    assert len(others) == 3
    assert len(smf.texts(0xFF07)) == 3


def test_music_without_a_tempo_has_that_of_the_dance_or_120(score_of: Any) -> None:
    sound = music("C4")
    del sound["tempo_bpm"]
    dance = DanceBeat(Fraction(90), Fraction(1))
    assert tempo_plan(score_of(sound=sound, dance=dance)).clock.spans[0].length == Fraction(2, 3)
    plan = tempo_plan(score_of(sound=sound))
    assert (plan.source, plan.clock.spans[0].length) == ("music", Fraction(1, 2))


def generated(score_of: Any, tension: float, motion: float, **config: Any) -> list[Note]:
    """Return a generated piece of 16 bars in a scene of constant tension and motion."""
    course = SceneCourse(1.0, (tension,), (motion,))
    sound = {"tempo_bpm": 120, "scale": "D dorian", "music": {"generate": config}}
    return played(score_of(sound=sound, frames=48 * 16, course=course))


def test_generated_music_follows_motion_and_tension(score_of: Any) -> None:
    still, lively = (generated(score_of, 0.2, motion) for motion in (0.05, 0.9))
    assert len(lively) > 2 * len(still)
    assert not any(note.drum for note in still)
    assert any(note.drum for note in lively)

    def melody(notes: list[Note]) -> float:
        return float(np.mean([n.pitch for n in notes if n.event.who == "music melody"]))

    calm, tense = (generated(score_of, tension, 0.5) for tension in (0.0, 1.0))
    assert melody(tense) > melody(calm) + 3
    roots = [
        [n.pitch % 12 for n in notes if n.event.who == "music bass" and n.onset.denominator == 1]
        for notes in (calm, tense)
    ]
    # At rest the tonic is home; under tension it is left.
    assert roots[0].count(2) / len(roots[0]) > roots[1].count(2) / len(roots[1]) + 0.1


def test_generated_music_is_in_its_scale_and_repeatable(score_of: Any) -> None:
    once, again = (generated(score_of, 0.4, 0.5) for _ in range(2))
    assert once == again
    assert once != generated(score_of, 0.4, 0.5, seed=1)
    dorian = {2, 4, 5, 7, 9, 11, 0}
    assert {note.pitch % 12 for note in once if not note.drum} <= dorian
    left = generated(score_of, 0.4, 0.9, leave_out=["drums", "melody"])
    assert {note.event.who for note in left} == {"music pad", "music bass", "music arpeggio"}


@pytest.mark.parametrize(
    ("change", "part"),
    [
        ({"sections": {"a": {"play": {"lede": "C4"}}}}, "did you mean 'lead'?"),
        ({"form": ["b"]}, "no section is called 'b'"),
        ({"form": ["a x0"]}, "plays nothing"),
        ({"sections": {"a": {"chords": "~", "play": {"lead": {"tones": "0"}}}}}, "no bar of"),
        ({"sections": {"a": {"bars": 1, "chords": "~ | C", "play": {"lead": "0"}}}}, "no bar of"),
        ({"sections": {"a": {"play": {"lead": {"notes": "C4", "step": "1/4"}}}}}, "an arpeggio"),
        ({"sections": {}, "parts": {}, "generate": {}, "loop": False}, "remove loop"),
        ({"generate": {}}, "got sections and generate"),
        ({"sections": {"a": {"play": {"lead": "C4 H4"}}}}, "'H4' is no note name"),
        ({"sections": {"a": {"play": {"lead": {"tones": "0"}}}}}, "give chords"),
        ({"sections": {"a": {"play": {"lead": {"drums": {"bass drum": "x"}}}}}}, "no drums"),
        ({"sections": {"a": {"chords": "Am7x", "play": {"lead": "C4"}}}}, "unknown chord"),
        ({"parts": {"lead": {"instrument": "floot"}}}, "did you mean 'flute'?"),
        ({"sections": {"a": {"play": {"lead": {"notes": "C4", "tones": "0"}}}}}, "give one of"),
    ],
)
def test_wrong_music_is_refused(change: dict[str, Any], part: str) -> None:
    sound = music("C4")
    sound["music"] |= change
    with pytest.raises(ValidationError) as error:
        Sound.model_validate(sound)
    assert part in str(error.value)


def test_numerals_need_a_scale_of_seven_steps() -> None:
    sound = {**music({"tones": "0"}, "i"), "scale": "C minor pentatonic"}
    with pytest.raises(ValidationError, match="a numeral needs a scale of seven steps"):
        Sound.model_validate(sound)


def test_too_many_notes_are_refused(score_of: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("audio.notes.MAX_MUSIC_NOTES", 100)
    assert len(played(score_of(sound=music("C4*10"), frames=48 * 10))) == 100
    with pytest.raises(ScoreError, match="the music has more than 100 notes"):
        notes_of(score_of(sound=music("C4*11"), frames=48 * 10))
