"""Registers `flaky://` in every process that has this folder in PYTHONPATH."""

import fsspec

fsspec.register_implementation("flaky", "flaky_files.FlakyFiles")
