"""Bodies: what has no joints."""
