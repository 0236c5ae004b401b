"""Shot -> frames -> film, with Mitsuba. Knows nothing of figures or gaits."""

__version__ = "0.1.0"
