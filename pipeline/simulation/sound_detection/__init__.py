"""Contacts, motions and signals -> sound events (Sims 1987, ch. 13).

A new cause has a model in the spec's `Detect`, a detector here, and a voice in
`audio/cause_voices.py`. Every module is imported, so that detectors register themselves.
"""

from importlib import import_module
from pkgutil import iter_modules

for _module in iter_modules(__path__):
    import_module(f"{__name__}.{_module.name}")
