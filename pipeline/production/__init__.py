"""From a scene to its film and score: stages, camera, shots, score, outputs."""
