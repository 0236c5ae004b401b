"""Key signature: the sharps and flats of a score's scale."""

from __future__ import annotations

from audio.harmony import MODES, Scale, parse_steps
from audio.score import Score

# Keys by their sharps, flats negative; B major's and G flat's are written with the fewer.
_MAJOR = {
    -6: "Gb",
    -5: "Db",
    -4: "Ab",
    -3: "Eb",
    -2: "Bb",
    -1: "F",
    0: "C",
    1: "G",
    2: "D",
    3: "A",
    4: "E",
    5: "B",
}
_MINOR = {
    -6: "Ebm",
    -5: "Bbm",
    -4: "Fm",
    -3: "Cm",
    -2: "Gm",
    -1: "Dm",
    0: "Am",
    1: "Em",
    2: "Bm",
    3: "F#m",
    4: "C#m",
    5: "G#m",
}
_MINOR_THIRD, _MAJOR_THIRD, _FIFTH = 3, 4, 7


def score_key(score: Score) -> str | None:
    """Return the key of a score's scale, such as "Am"; None if its scene sets none."""
    if "scale" not in score.sound.model_fields_set:
        return None
    return scale_key(parse_steps(score.sound.scale))


def scale_key(scale: Scale) -> str | None:
    """Return the key whose signature suits a scale best; None for one without a fifth or third.

    A mode has the signature of its notes: D dorian is written as A minor.
    """
    steps = set(scale.intervals)
    minor = _MINOR_THIRD in steps
    is_chromatic = minor and _MAJOR_THIRD in steps
    if is_chromatic or not steps & {_MINOR_THIRD, _MAJOR_THIRD} or _FIFTH not in steps:
        return None
    notes = {(scale.root + step) % 12 for step in steps}
    own = MODES["minor" if minor else "major"]
    tonic = scale.root
    if not notes <= {(scale.root + step) % 12 for step in own}:
        tonic = next(
            (root for root in _by_fifths(scale.root) if notes <= _scale_notes(root, own)),
            scale.root,
        )
    major = (tonic + 3) % 12 if minor else tonic
    sharps = (7 * major + 6) % 12 - 6
    return (_MINOR if minor else _MAJOR)[sharps]


def _by_fifths(root: int) -> list[int]:
    """Return all roots, those of near signatures first."""
    near = sorted(range(-5, 7), key=lambda fifths: (abs(fifths), fifths))
    return [(root + 7 * fifths) % 12 for fifths in near]


def _scale_notes(root: int, steps: tuple[int, ...]) -> set[int]:
    return {(root + step) % 12 for step in steps}
