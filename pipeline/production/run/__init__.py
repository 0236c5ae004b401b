"""A scene to its outputs: what is due, workers, manifest, progress."""
