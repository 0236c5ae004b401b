"""Goldens: regression tests of films in three layers of rising cost.

- motion: poses, contacts, sound events, notes of the score, camera poses; no rendering;
- frames: a few small pictures of fixed samples, before the denoiser;
- film: the container, its decoded pictures, and the onsets of its sound.

A golden is a folder beside the scene. Equal bits pass; other bits are judged by the limits of the
golden. Only `record`, `approve` and `calibrate --write` write goldens, and none of them where `CI`
is set.
"""
