"""Contacts, motions and happenings -> sound events, one file each (Sims 1987, ch. 13).

A new cause is a model in `pipeline/spec/sound_thresholds.py`, a file here and a line in one of the
registries.
"""

from pipeline.simulation.detect.bends import Squawks, Squeaks
from pipeline.simulation.detect.boings import Boings
from pipeline.simulation.detect.breaths import Breaths
from pipeline.simulation.detect.collisions import collisions
from pipeline.simulation.detect.footfalls import footfalls
from pipeline.simulation.detect.motions import MakesWatch
from pipeline.simulation.detect.rubs import rolls, slides
from pipeline.simulation.detect.scuffs import scuffs
from pipeline.simulation.detect.swooshes import Swooshes
from pipeline.simulation.detect.whistles import Whistles

OF_CONTACTS = {
    "footfall": footfalls,
    "scuff": scuffs,
    "collision": collisions,
    "roll": rolls,
    "slide": slides,
}
"""Cause -> which contacts make it, see `Contacts`."""

OF_MOTIONS: dict[str, MakesWatch] = {
    "squeak": Squeaks,
    "squawk": Squawks,
    "swoosh": Swooshes,
    "whistle": Whistles,
    "boing": Boings,
    "breath": Breaths,
}
"""Cause -> what watches the rows for it, see `Motions`."""

OF_HAPPENINGS = {"cry": "cry", "hug": "hug"}
"""Cause -> the kind of happening that makes it, see `Voices`."""
