"""Instruments: synthesis of the families of General MIDI."""
