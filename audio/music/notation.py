"""Bar notation: texts such as "C4 [E4 G4] ~ x(3,8) | %" as steps within bars.

Steps between blanks share a bar evenly. `[a b]` divides a step, `[a, b]` sounds together, `a*3`
repeats within its step, `a!3` is three steps, `a@3` one three times as long, `a(3,8,2)` a Euclidean
rhythm of 3 onsets in 8 steps from the third on, `a^` an accent, `~` a rest, `_` holds what sounds
before it, `|` ends a bar and `%` repeats the bar before.

Sources: McLean 2020 (TidalCycles) for the notation; Toussaint 2005 for Euclidean rhythms.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache

REST, HOLD = "~", "_"
MAX_BARS = 256
"""Greatest number of bars of a text."""

MAX_STEPS = 1024
"""Greatest number of notes of a bar."""

_MAX_DEPTH = 8
_MAX_TIMES = 64
_SUFFIX = re.compile(
    r"\*(?P<times>\d+)|@(?P<weight>\d+)|!(?P<copies>\d+)|(?P<accent>\^)"
    r"|\(\s*(?P<onsets>\d+)\s*,\s*(?P<slots>\d+)\s*(?:,\s*(?P<turn>-?\d+)\s*)?\)"
)
_ATOM = re.compile(r"[^\s\[\](),|*@!~%^_]+")
_STROKE = re.compile(r"[xXo.]")


class NotationFault(ValueError):
    """A text that is no bar notation."""


@dataclass(frozen=True, slots=True)
class Step:
    """A sound within a bar.

    Attributes:
        start: from 0 to 1 of the bar.
        length: of the bar.
        text: what sounds; `HOLD` where what sounded before lasts on.
        accent: whether it is accented.
    """

    start: Fraction
    length: Fraction
    text: str
    accent: bool = False


@dataclass(frozen=True, slots=True)
class _Term:
    """A step before it has a place: a text, or layers of terms that sound together."""

    text: str = ""
    layers: tuple[tuple[_Term, ...], ...] = ()
    weight: int = 1
    accent: bool = False


_NOTHING = _Term(REST)


def euclidean_rhythm(onsets: int, slots: int, turn: int = 0) -> tuple[bool, ...]:
    """Return where onsets lie that are spread over slots as evenly as possible, from an onset on.

    Source: Toussaint 2005; Bresenham's line gives the same necklaces as Bjorklund's algorithm.
    """
    pattern = [(slot * onsets) % slots < onsets for slot in range(slots)]
    return tuple(pattern[(slot + turn) % slots] for slot in range(slots))


@lru_cache(maxsize=4096)
def parse_bars(text: str, strokes: bool = False) -> tuple[tuple[Step, ...], ...]:
    """Return the steps of each bar of a text, in the order of time.

    Args:
        text: bar notation.
        strokes: whether each of `x`, `X` (accent), `o` (soft) and `.` (rest) is a step by itself,
            and blanks do not matter.

    Raises:
        NotationFault: the text is no bar notation; the message names the place.
    """
    pieces = text.strip().strip("|").split("|")
    if len(pieces) > MAX_BARS:
        raise NotationFault(f"{len(pieces)} bars; a text has at most {MAX_BARS}")
    bars: list[tuple[Step, ...]] = []
    for number, piece in enumerate(pieces, start=1):
        if piece.strip() == "%":
            if not bars:
                raise NotationFault("'%' repeats the bar before it, and the first has none")
            bars.append(bars[-1])
            continue
        try:
            bars.append(_Reader(piece, strokes).bar())
        except NotationFault as error:
            raise NotationFault(f"bar {number}, {piece.strip()!r}: {error}") from None
    if any(step.text == HOLD and not step.start for step in bars[0]):
        raise NotationFault(f"'{HOLD}' holds what sounds before it, and the first step has nothing")
    return tuple(bars)


class _Reader:
    """Reads the terms of one bar."""

    def __init__(self, text: str, strokes: bool) -> None:
        self._text, self._at = text, 0
        self._atom = _STROKE if strokes else _ATOM
        self._strokes = strokes

    def bar(self) -> tuple[Step, ...]:
        layers = self._layers(0)
        if self._at < len(self._text):
            raise NotationFault(f"nothing is open that {self._text[self._at]!r} could close")
        steps: list[Step] = []
        for layer in layers:
            for step in _placed(layer, Fraction(0), Fraction(1), False):
                steps.append(step)
                if len(steps) > MAX_STEPS:
                    raise NotationFault(f"a bar has at most {MAX_STEPS} notes")
        return tuple(sorted(steps, key=lambda step: (step.start, step.text != HOLD)))

    def _layers(self, depth: int) -> tuple[tuple[_Term, ...], ...]:
        if depth > _MAX_DEPTH:
            raise NotationFault(f"brackets are at most {_MAX_DEPTH} deep")
        layers: list[list[_Term]] = [[]]
        while True:
            self._skip_blanks()
            mark = self._text[self._at : self._at + 1]
            if mark == ",":
                layers.append([])
                self._at += 1
            elif not mark or mark == "]":
                return tuple(tuple(layer) for layer in layers)
            else:
                layers[-1] += self._term(depth)
            if sum(map(len, layers)) > MAX_STEPS:
                raise NotationFault(f"a bar has at most {MAX_STEPS} notes")

    def _skip_blanks(self) -> None:
        while self._text[self._at : self._at + 1].isspace():
            self._at += 1

    def _term(self, depth: int) -> Iterator[_Term]:
        mark = self._text[self._at]
        if mark == "[":
            self._at += 1
            term = _Term(layers=self._layers(depth + 1))
            if self._text[self._at : self._at + 1] != "]":
                raise NotationFault("a bracket '[' is not closed")
            self._at += 1
        elif mark in (REST, HOLD):
            self._at += 1
            term = _Term(mark)
        else:
            atom = self._atom.match(self._text, self._at)
            if atom is None:
                hint = " (a step is x, X, o or a dot)" if self._strokes else ""
                raise NotationFault(f"{mark!r} is no step{hint}")
            self._at = atom.end()
            term = _NOTHING if self._strokes and atom[0] == "." else _Term(atom[0])
        return self._with_suffixes(term)

    def _with_suffixes(self, term: _Term) -> Iterator[_Term]:
        copies = 1
        while suffix := _SUFFIX.match(self._text, self._at):
            self._at = suffix.end()
            numbers = {key: int(value) for key, value in suffix.groupdict().items()
                       if value is not None and key != "accent"}  # fmt: skip
            for key in ("times", "weight", "copies", "slots"):
                if not 1 <= numbers.get(key, 1) <= _MAX_TIMES:
                    raise NotationFault(f"{suffix[0]!r}: numbers are 1 to {_MAX_TIMES}")
            if suffix["accent"]:
                term = replace(term, accent=True)
            elif suffix["times"]:
                term = _Term(layers=((term,) * numbers["times"],))
            elif suffix["weight"]:
                term = replace(term, weight=numbers["weight"])
            elif suffix["copies"]:
                copies = numbers["copies"]
            else:
                onsets, slots = numbers["onsets"], numbers["slots"]
                if onsets > slots:
                    raise NotationFault(f"{suffix[0]!r}: {slots} steps have no {onsets} onsets")
                beats = euclidean_rhythm(onsets, slots, numbers.get("turn", 0))
                term = _Term(layers=(tuple(term if beat else _NOTHING for beat in beats),))
        yield from [term] * copies


def _placed(
    terms: tuple[_Term, ...], start: Fraction, length: Fraction, accent: bool
) -> Iterator[Step]:
    """Yield the steps of terms that share a stretch of a bar by their weights."""
    whole = sum(term.weight for term in terms)
    for term in terms:
        share = length * term.weight / whole
        for layer in term.layers:
            yield from _placed(layer, start, share, accent or term.accent)
        if term.text and term.text != REST:
            yield Step(start, share, term.text, accent or term.accent)
        start += share
