"""pronk: one scene in, a film and its score out."""

from pipeline.processor import hold

__version__ = "0.1.0"

HELD = hold()
"""Whether takes made in this process are the same bytes as on other processors of its kind."""
