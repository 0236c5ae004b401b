"""A scene to its outputs: stages, workers, manifest, progress."""
