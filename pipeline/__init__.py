"""pronk: one scene in, a film and its score out."""

__version__ = "0.1.0"
