"""Score -> MIDI and WAV. Knows nothing of terrain or figures.

`audio.midi.write_midi` and `audio.modal.write_wav` write a `Score`; `audio.words.Sound` are the
author's words.
"""

__version__ = "0.1.0"
