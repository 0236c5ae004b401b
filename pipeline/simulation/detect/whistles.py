"""Whistles: thin props and bodies that sing in the air.

Behind what is d thick vortices come off at f = 0.2 v / d: below some tone nothing sings.

Source: Sims 1987, 13.1.2; Strouhal 1878 (the tone of a wire in the wind).
"""

from __future__ import annotations

import numpy as np

from pipeline.simulation.detect.flights import Flights
from pipeline.simulation.detect.hearing import fits
from pipeline.simulation.detect.scenery import Scenery
from pipeline.spec.sound_thresholds import Detect

STROUHAL = 0.2
"""Of long round bodies, at the speeds that are heard."""


class Whistles(Flights):
    """What whistles."""

    def __init__(self, scenery: Scenery, detect: Detect) -> None:
        words = detect.whistle
        solids = [s for s in scenery.flying if fits(s.performer, words.who)]
        least = np.array([words.least_hz * s.thickness / STROUHAL for s in solids])
        super().__init__(scenery, solids, words, "whistle", least)
