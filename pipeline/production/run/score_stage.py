"""Score stage: MIDI, WAV, events, edit list and labels of a take."""

from __future__ import annotations

from collections.abc import Collection

from audio.errors import SoundFontError
from audio.layouts import LAYOUTS
from audio.midi_file import write_midi
from audio.score import Score
from audio.surround_file import write_surround
from audio.wav_file import WavReport, write_wav
from pipeline.errors import Problem, SceneError
from pipeline.production.run.progress import stage
from pipeline.production.run.scene_run import SceneRun
from pipeline.production.shots.shot_builder import ShotBuilder
from pipeline.production.sound.cue_files import write_cues
from pipeline.production.sound.event_files import write_events
from pipeline.production.sound.export_kind import ExportKind
from pipeline.production.sound.score_builder import build_score
from pipeline.production.sound.score_export import export_score
from pipeline.production.sound.sound_report import (
    asked_loudness,
    loudness_summary,
    midi_facts,
    quantisation_summary,
    wav_facts,
)
from pipeline.simulation.take import Take


def store_events(run: SceneRun, take: Take) -> bool:
    """Write the sound events of a take; return whether a file changed."""
    changed = write_events(run.outputs, take)
    run.records.update(run.outputs.events, run.outputs.event_table)
    return changed


def write_score(run: SceneRun, take: Take, shooting: ShotBuilder) -> tuple[Score, WavReport]:
    """Write MIDI, WAV, events, edit list and labels, inside `working`."""
    with stage(run.reporter, "score", 3, "files") as current:
        score, late = build_score(shooting.scene, take, shooting.poses, run.order.subframe)
        changed = store_events(run, take)
        changed |= write_cues(run.outputs, score, run.whole_film.name)
        current.advance(1)
        midi = write_midi(score, run.outputs.midi)
        current.advance(2)
        wav = _write_sound(run, score)
        changed |= _write_surround(run, score, wav)
        if changed or midi.changed or wav.changed:
            run.record_time(current)
        current.result = (
            f"{len(score.events)} events, {loudness_summary(wav, asked_loudness(score))}"
            + (f", {late} after the last frame" if late else "")
        )
    if not run.outputs.edit_list.exists():
        run.reporter.note(
            f"score: {score.rate} frames a second have no timecode, or the film lasts longer than "
            "a day; no edit list is written"
        )
    moved = quantisation_summary(midi.shifts, score)
    if moved is not None:
        run.reporter.note(moved)
    outputs = run.outputs
    run.records.update(outputs.midi, outputs.wav, outputs.labels, outputs.edit_list)
    run.manifest.entries["events"] = {"written": len(score.events), "after_the_last_frame": late}
    run.manifest.entries["midi"] = midi_facts(midi, score.subframe, score.rate)
    run.manifest.entries["wav"] = wav_facts(wav)
    return score, wav


def store_exports(
    run: SceneRun, score: Score, wav: WavReport, kinds: Collection[ExportKind]
) -> None:
    """Write the score for other programs, inside `working`, after the score itself."""
    with stage(run.reporter, "export", 1, "files") as current:
        exported = export_score(run.outputs, score, kinds, wav.gain, wav.curve, wav.music_gain)
        current.advance(1)
        current.result = f"{len(exported.paths)} files in {run.outputs.score_folder.name}"
    run.records.update(*exported.paths, *exported.removed)


def _write_surround(run: SceneRun, score: Score, wav: WavReport) -> bool:
    """Write the sound in the layout that the scene asks for; return whether a file changed."""
    wanted, changed = score.sound.channels, False
    for layout in LAYOUTS:
        path = run.outputs.surround(layout)
        if layout == wanted != "stereo":
            changed |= write_surround(score, path, layout, wav)
        elif path.exists():
            # Of a scene that asked for another one.
            path.unlink()
            changed = True
        run.records.update(path)
    return changed


def _write_sound(run: SceneRun, score: Score) -> WavReport:
    """Write the WAV file.

    Raises:
        SceneError: the SoundFont of the scene cannot be played.
    """
    try:
        return write_wav(score, run.outputs.wav)
    except SoundFontError as error:
        problem = Problem("sound.soundfont", str(error))
        raise SceneError([run.order.scene.source_map.with_location(problem)]) from error
