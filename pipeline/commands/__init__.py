"""Commands that come in groups; no logic."""
