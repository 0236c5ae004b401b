"""The examples of docs/sound.md load and play."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import pytest

from audio.config.music import Line, Music, MusicGenerator, MusicPart, MusicSection
from audio.config.phrase import Phrase, PhraseStep
from audio.config.quantisation import Quantisation
from audio.config.sound import EventFilter, Sound, Voice
from audio.config.velocity import Velocity
from audio.harmony import CHORD_KINDS, MODES
from audio.midi_file import midi_bytes
from pipeline.spec import load_scene

PAGE = (Path(__file__).parents[2] / "docs" / "sound.md").read_text(encoding="utf-8")
EXAMPLES = [text for text in re.findall(r"```yaml\n(.*?)```", PAGE, re.DOTALL) if "sound:" in text]

CAST = ("bug", "ghost", "mare", "calf", "roo", "drummer", "robot", "horse")


def test_there_are_examples() -> None:
    assert len(EXAMPLES) >= 5


@pytest.mark.parametrize("example", EXAMPLES)
def test_every_example_loads_and_plays(
    example: str, tmp_path: Path, step: Any, score_of: Any, read_smf: Any, check_laws: Any
) -> None:
    path = tmp_path / "example.yaml"
    cast = ", ".join(f"{{figure: beetle, name: {name}}}" for name in CAST)
    path.write_text(f"pronk: 1\nduration: 1\ncast: [{cast}]\n{example}", encoding="utf-8")
    sound = load_scene(path).sound
    voices = sound.voices
    events = [
        step(1 + i, who=(voice.when.who or "bug"), cause=(voice.when.cause or "footfall"))
        for i, voice in enumerate(voices)
    ]
    config = {name: getattr(sound, name) for name in Sound.model_fields}
    smf = read_smf(midi_bytes(score_of(events, sound=config)))
    drums = sound.music is not None or any(voice.drum for voice in voices)
    check_laws(smf, 24, 24, drums=drums)
    heard = len([voice for voice in voices if not voice.mute])
    assert len(smf.onsets()) >= heard


def test_the_page_names_every_scale_chord_and_key() -> None:
    for kind in (*MODES, *filter(None, CHORD_KINDS)):
        assert f"`{kind}`" in PAGE, kind
    said = set(re.findall(r"[a-z_]+", PAGE))
    of_music = (Music, MusicPart, MusicSection, MusicGenerator, Line)
    for model in (
        *(Sound, Voice, EventFilter, Quantisation, Velocity, Phrase, PhraseStep),
        *of_music,
    ):
        assert set(model.model_fields) <= said, model
