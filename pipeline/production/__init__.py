"""From a scene to its film and score: what is due, camera, shots, score, outputs."""
