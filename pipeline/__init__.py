"""pronk: one scene in, a film and its score out."""

from pipeline.processor import hold

__version__ = "0.1.0"

HELD = hold()
"""Whether takes made in this process equal those of every other held processor byte for byte."""
