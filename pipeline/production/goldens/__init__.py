"""Goldens: a film's regression tests, in three layers that each cost more than the one before.

- motion: poses, contacts, sound events, the notes of the score, the camera's way; no rendering;
- frames: a few small pictures of fixed samples, before the denoiser;
- film: the container, the pictures decoded from it, and when its sound begins.

A golden is a folder beside the scene. What is equal to the last bit passes; what is not is
judged by limits that stand in the golden. Nothing but `record`, `approve` and
`calibrate --write` writes one, and none of them where `CI` is set.
"""
