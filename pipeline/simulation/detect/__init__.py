"""Contacts and motions -> sound events, one file each (Sims 1987, ch. 13).

A new cause is a file here and a line in `DETECTORS`.
"""

from pipeline.simulation.detect.collisions import collisions
from pipeline.simulation.detect.footfalls import footfalls
from pipeline.simulation.detect.rubs import rubs
from pipeline.simulation.detect.scuffs import scuffs
from pipeline.simulation.detect.takeoffs import takeoffs

DETECTORS = (footfalls, takeoffs, scuffs, collisions, rubs)
"""Functions (contacts of one step, clock) -> sound events."""
