"""Take and camera -> score; the files beside MIDI and WAV."""
