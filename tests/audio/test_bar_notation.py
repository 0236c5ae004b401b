"""Bar notation: steps within bars, Euclidean rhythms, and texts that are refused."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from audio.music.notation import MAX_STEPS, NotationFault, Step, euclidean_rhythm, parse_bars


def places(text: str, strokes: bool = False) -> list[list[tuple[str, str, str]]]:
    """Return text, start and length of each step of each bar."""
    return [
        [(step.text, str(step.start), str(step.length)) for step in bar]
        for bar in parse_bars(text, strokes)
    ]


def test_steps_share_a_bar_and_brackets_a_step() -> None:
    assert places("C4 ~ [E4 G4] A4") == [
        [("C4", "0", "1/4"), ("E4", "1/2", "1/8"), ("G4", "5/8", "1/8"), ("A4", "3/4", "1/4")]
    ]


def test_suffixes_repeat_lengthen_and_copy() -> None:
    assert places("a*2 b@2 c!2")[0] == [
        *(("a", "0", "1/10"), ("a", "1/10", "1/10"), ("b", "1/5", "2/5")),
        *(("c", "3/5", "1/5"), ("c", "4/5", "1/5")),
    ]
    assert parse_bars("a^ b")[0] == (
        Step(Fraction(0), Fraction(1, 2), "a", True),
        Step(Fraction(1, 2), Fraction(1, 2), "b"),
    )


def test_layers_sound_together_and_bars_repeat() -> None:
    first, second, third = places("[C4, E4 G4] A4 | % | B4")
    assert first == second
    assert [(text, start) for text, start, _ in first] == [
        *(("C4", "0"), ("E4", "0"), ("G4", "1/4"), ("A4", "1/2"))
    ]
    assert third == [("B4", "0", "1")]


def test_strokes_are_steps_whatever_blanks_lie_between() -> None:
    assert places("x.. x.. X.", strokes=True) == places("x..x..X.", strokes=True)
    assert [start for _, start, _ in places("x..x..X.", strokes=True)[0]] == ["0", "3/8", "3/4"]


@pytest.mark.parametrize(
    ("onsets", "slots", "rhythm"),
    # Toussaint 2005: tresillo, cinquillo, the rhythm of a Persian song, bossa nova.
    [(3, 8, "x..x..x."), (5, 8, "x.xx.xx."), (2, 5, "x.x.."), (5, 16, "x..x..x..x..x...")],
)
def test_euclidean_rhythms_are_those_of_the_literature(
    onsets: int, slots: int, rhythm: str
) -> None:
    found = "".join("x" if beat else "." for beat in euclidean_rhythm(onsets, slots))
    assert found in {rhythm[turn:] + rhythm[:turn] for turn in range(slots)}
    assert found[0] == "x"


@given(st.integers(1, 32), st.integers(1, 32), st.integers(-40, 40))
def test_euclidean_rhythms_are_even(onsets: int, slots: int, turn: int) -> None:
    onsets = min(onsets, slots)
    rhythm = euclidean_rhythm(onsets, slots, turn)
    places = [slot for slot, beat in enumerate(rhythm) if beat]
    assert len(places) == onsets
    gaps = {(b - a) % slots or slots for a, b in zip(places, places[1:] + places[:1], strict=True)}
    assert max(gaps) - min(gaps) <= 1


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("C4 [E4", "'[' is not closed"),
        ("C4 ]", "nothing is open"),
        ("x(9,8)", "8 steps have no 9 onsets"),
        ("% | C4", "the first has none"),
        ("_ C4", "the first step has nothing"),
        ("C4*0", "numbers are 1 to 64"),
        ("C4 ) E4", "')' is no step"),
        ("[[[[[[[[[[a]]]]]]]]]]", "at most 8 deep"),
        ("[a*64]*64", f"at most {MAX_STEPS} notes"),
        ("|".join(["a"] * 300), "at most 256"),
    ],
)
def test_what_is_no_notation_is_refused_with_its_bar(text: str, part: str) -> None:
    with pytest.raises(NotationFault) as error:
        parse_bars(text)
    assert part in str(error.value)


@given(st.text(alphabet="ab x~_[](),|*@!%^0123456789.", max_size=40))
def test_no_text_does_more_than_be_refused(text: str) -> None:
    try:
        bars = parse_bars(text)
    except NotationFault:
        return
    for bar in bars:
        assert all(step.length > 0 and 0 <= step.start < 1 for step in bar)
        assert all(step.start + step.length <= 1 for step in bar)
