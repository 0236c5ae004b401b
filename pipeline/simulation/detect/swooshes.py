"""Swooshes: props and bodies that speed through the air.

What is large must go faster: at so many of its own lengths a second.

Source: Sims 1987, 13.1.2.
"""

from __future__ import annotations

import numpy as np

from pipeline.simulation.detect.flights import Flights
from pipeline.simulation.detect.hearing import fits
from pipeline.simulation.detect.scenery import Scenery
from pipeline.spec.sound_thresholds import Detect


class Swooshes(Flights):
    """What swooshes."""

    def __init__(self, scenery: Scenery, detect: Detect) -> None:
        words = detect.swoosh
        solids = [s for s in scenery.flying if fits(s.performer, words.who)]
        least = np.array([words.sizes_s * s.size for s in solids])
        super().__init__(scenery, solids, words, "swoosh", least)
