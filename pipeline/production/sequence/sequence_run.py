"""Sequence run: the clips of a sequence rendered one after the other, then joined."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

from audio.joined_sound import SoundPiece, write_joined_sound
from audio.time_grid import sample_of_frame
from pipeline.atomic_file import write_if_changed
from pipeline.errors import SceneError
from pipeline.production.run import production
from pipeline.production.run.encoder_check import require_encoders
from pipeline.production.run.file_records import FileRecords
from pipeline.production.run.frame_ranges import counted
from pipeline.production.run.manifest import Manifest, library_versions
from pipeline.production.run.order import Order
from pipeline.production.run.outputs import Outputs, opened
from pipeline.production.run.progress import Reporter, Stage, stage
from pipeline.production.run.scene_run import translated_errors, write_errors
from pipeline.production.sequence.sequence_source import CLIPS, SequenceSource, titled_film
from pipeline.production.shots.title_timing import problems_of_titles, require_titles
from pipeline.spec import Scene, SceneSequence
from render.film_encoder import write_film
from render.film_segments import Picture

MakeOrder = Callable[[Scene, str, Path, str], Order]
"""Returns the order of a clip: of its scene, its name, the folder of clips and its frames."""


def check_sequence(sequence: SceneSequence) -> None:
    """Refuse a sequence whose words cannot be shown or whose film cannot be encoded.

    Raises:
        SceneError: with all that is wrong.
    """
    problems = list(problems_of_titles(titled_film(sequence)))
    if problems:
        raise sequence.source_map.with_locations(SceneError(problems))
    for clip in sequence.clips:
        require_titles(clip.scene)
        require_encoders(clip.scene)


def render_sequence(
    sequence: SceneSequence, out: Path, order_of: MakeOrder, reporter: Reporter
) -> Outputs:
    """Render the clips of a sequence that are due, and join them.

    Args:
        sequence: with its scenes.
        out: folder that holds the folders of outputs.
        order_of: makes the orders of clips.
        reporter: of progress.

    Raises:
        PronkError: something cannot be made; earlier outputs stay.
    """
    check_sequence(sequence)
    outputs = Outputs(out / sequence.name, sequence.name)
    with opened(outputs):
        orders = list(_orders(sequence, outputs, order_of))
        for number, order in enumerate(orders, start=1):
            reporter.scene(order.name, number, len(orders))
            production.render(order, reporter)
        manifest = Manifest.read(outputs.manifest)
        manifest.files = records = FileRecords(outputs.folder, manifest.files)
        before = manifest.encoded()
        with write_errors(outputs), translated_errors():
            _join(sequence, orders, outputs, manifest, records, reporter)
        data = manifest.encoded()
        if data != before:
            write_if_changed(outputs.manifest, data)
    return outputs


def _orders(sequence: SceneSequence, outputs: Outputs, order_of: MakeOrder) -> Iterator[Order]:
    for clip in sequence.clips:
        frames = f"{clip.first}-{clip.last}"
        order = order_of(clip.scene, clip.name, outputs.folder / CLIPS, frames)
        yield replace(order, film=False)


def _join(
    sequence: SceneSequence,
    orders: list[Order],
    outputs: Outputs,
    manifest: Manifest,
    records: FileRecords,
    reporter: Reporter,
) -> None:
    """Write the sound and the film of a sequence whose clips are rendered."""
    source = SequenceSource.of(sequence, orders[0].sound)
    if source.has_sound:
        samples = sample_of_frame(sequence.n_frames + 1, sequence.rate)
        write_joined_sound(outputs.wav, list(_pieces(sequence, source, outputs)), samples)
        records.update(outputs.wav)
    film = sequence.clips[0].scene.film.resolved()
    place, key = outputs.film(suffix=film.suffix), source.key(outputs, records)
    with stage(reporter, "film", source.n_frames, "frames") as current:
        if records.is_intact(place, key):
            current.result = f"{place.name} is up to date"
        else:
            pictures = _reported(source.pictures(outputs), current)
            sound = outputs.wav if source.has_sound else None
            write_film(place, pictures, source.rate, sound, key=key, codec=source.codec)
            records.add(place, key)
            manifest.seconds[current.name] = round(current.seconds, 3)
            current.result = (
                f"{place.name}, {counted(source.n_frames)} of {len(source.clips)} clips"
                + (", with sound" if sound else "")
            )
    records.forget_missing()
    manifest.entries |= {
        "scene": sequence.name,
        "title": sequence.title,
        "rate": str(sequence.rate),
        "frames": sequence.n_frames,
        "versions": library_versions(),
        "films": {place.name: source.facts},
    }


def _pieces(
    sequence: SceneSequence, source: SequenceSource, outputs: Outputs
) -> Iterator[SoundPiece]:
    """Yield the sounds of the clips; each begins and ends on a frame."""
    rate = sequence.rate
    for clip, own in zip(sequence.clips, source.clips, strict=True):
        first, at = sample_of_frame(clip.first, rate), sample_of_frame(clip.at + 1, rate)
        end = sample_of_frame(clip.at + clip.frames + 1, rate)
        rise = sample_of_frame(clip.at + clip.rise + 1, rate) - at
        fall = end - sample_of_frame(clip.at + clip.frames - clip.fall + 1, rate)
        yield SoundPiece(own.outputs(outputs).wav, first, end - at, at, rise, fall)


def _reported(pictures: Iterator[Picture], current: Stage) -> Iterator[Picture]:
    for done, picture in enumerate(pictures):
        current.advance(done)
        yield picture
