"""Score -> MIDI and WAV. Imports nothing of the project.

`audio.midi_file.write_midi` and `audio.wav_file.write_wav` write a `Score`;
`audio.config.sound.Sound` is the sound section of a scene file.
"""

__version__ = "0.1.0"
