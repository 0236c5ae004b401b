"""Expressions: the emotions that a face can show."""

from __future__ import annotations

from typing import Literal, get_args

Emotion = Literal["joy", "sadness", "anger", "fear", "pain", "curiosity"]

Shown = Literal["joy", "sadness", "anger", "fear", "pain", "curiosity", "neutral", "own"]
"""What an order can ask a face to show."""

EMOTIONS: tuple[Emotion, ...] = get_args(Emotion)
