"""Scene models: frames, rates, names, terrains."""

from __future__ import annotations

import math
from decimal import Decimal
from fractions import Fraction

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from pydantic import ValidationError

from pipeline.spec import Creature, Figure, Scene, Walk
from pipeline.spec.terrain.kinds import FlatTerrain, HillsTerrain

BUG = Figure(nodes={"head": [0, -1], "hip": [0, 0]}, chains=[["head", "hip"]])


def scene(**config):
    given = {"pronk": 1, "figures": {"bug": BUG}, "cast": [{"figure": "bug"}], **config}
    return Scene.model_validate(given)


@pytest.mark.parametrize(
    ("duration", "fps", "frames"),
    [
        (6, 24, 144),
        (0.1, 30, 3),  # 0.1 as a binary number is more than a tenth
        (1.1, 30, 33),
        (0.7, 10, 7),
        (0.71, 10, 8),
        (1e-9, 24, 1),
        (1, "30000/1001", 30),
        (10.01, "30000/1001", 300),
        (10.0101, "30000/1001", 301),
        (1_000_000, 1, 1_000_000),
    ],
)
def test_frames_are_rounded_up_from_the_decimal_that_was_written(duration, fps, frames):
    assert scene(duration=duration, fps=fps).n_frames == frames


@given(st.decimals("0.001", "4000", places=3), st.integers(1, 240))
def test_the_film_is_never_shorter_and_less_than_a_frame_longer(duration, fps):
    n = scene(duration=float(duration), fps=fps).n_frames
    assert (n - 1) < Fraction(Decimal(duration)) * fps <= n


def test_the_key_frames_sets_the_number_of_frames():
    assert scene(frames=7, fps="24000/1001").n_frames == 7
    assert scene(frames=7, fps="24000/1001").rate == Fraction(24000, 1001)


@pytest.mark.parametrize(
    "config",
    [
        {},
        {"duration": 1, "frames": 24},
        {"duration": "1"},
        {"duration": True},
        {"duration": math.nan},
        {"duration": math.inf},
        {"frames": 1_000_001},
        {"frames": 1, "rows_per_frame": 3},
        {"frames": 1, "seed": 2**63},
        {"frames": 1, "cast": []},
        {"frames": 1, "cast": [{"figure": "bog"}]},
        {"frames": 1, "fps": "30000 / 1001"},
        {"frames": 1, "fps": "1e3/1"},
        {"frames": 1, "fps": "٣/1"},
    ],
)
def test_invalid_scenes_are_refused_without_a_file(config):
    with pytest.raises(ValidationError):
        scene(**config)


def test_unnamed_members_get_the_name_of_their_figure_and_a_number():
    cast = [
        {"figure": "bug"},
        {"figure": "bug", "name": "bug_2"},
        {"figure": "bug"},
        {"figure": "bug", "name": "queen"},
        {"figure": "bug"},
    ]
    names = [member.name for member in scene(frames=1, cast=cast).cast]
    assert names == ["bug", "bug_2", "bug_3", "queen", "bug_4"]


def test_names_of_unnamed_walls_differ_from_names_of_bricks():
    cast = [{"many": {"of": "brick", "rows": 3, "columns": 3}} for _ in range(3)]
    assert [m.name for m in scene(frames=1, cast=cast).cast] == ["wall", "wall2", "wall3"]


def test_an_unnamed_member_avoids_names_of_later_members():
    cast = [{"figure": "bug"}, {"figure": "bug", "name": "bug"}]
    assert [m.name for m in scene(frames=1, cast=cast).cast] == ["bug_2", "bug"]


def test_defaults_make_a_film():
    made = scene(duration=1)
    assert made.rate == 24
    assert (made.seed, made.rows_per_frame, made.steps) == (1, 4, 4)
    assert made.terrain == FlatTerrain()
    assert made.terrain.cells == (240, 240)
    assert made.cast[0] == Creature(name="bug", figure="bug")
    assert made.cast[0].walk is None


def test_terrain_by_name_by_preset_and_in_full_are_equal():
    full = HillsTerrain(height=2)
    for config in ({"kind": "hills", "height": 2}, {"preset": "hills", "height": 2}, full):
        assert scene(duration=1, terrain=config).terrain == full
    assert scene(duration=1, terrain="hills").terrain == HillsTerrain()


def test_models_are_immutable():
    made = scene(duration=1)
    with pytest.raises(ValidationError):
        made.seed = 2
    with pytest.raises(ValidationError):
        made.cast[0].scale = 2


@given(st.floats(1e-3, 1e3), st.floats(1e-3, 1e3))
def test_a_stride_must_equal_speed_times_cycle(speed, cycle):
    stride = speed * cycle
    assume(stride <= 10_000)
    Walk(speed=speed, cycle=cycle, stride=stride)
    with pytest.raises(ValidationError, match="stride = speed"):
        Walk(speed=speed, cycle=cycle, stride=stride * (1 - 3e-6))


@given(st.floats(0.01, 90), st.floats(0.01, 90), st.floats(0.01, 9000))
def test_suggested_values_of_a_walk_work(speed, cycle, stride):
    try:
        Walk(speed=speed, cycle=cycle, stride=stride)
    except ValidationError as error:
        message = error.errors()[0]["msg"].partition("take ")[2].replace(" or ", ", ")
        proposals = [one.split(": ") for one in message.split(", ")]
        assert [key for key, _ in proposals] == ["stride", "speed", "cycle"]
        given = {"speed": speed, "cycle": cycle, "stride": stride}
        for key, value in proposals:
            if key != "stride" and float(value) > 1000:
                continue  # beyond the range of that key
            Walk(**{**given, key: float(value)})


def test_operations_see_nodes_of_earlier_operations():
    figure = {
        "nodes": {"hip": [0, 0], "foot": [1, 1]},
        "chains": [["hip", "foot"]],
        "then": [{"mirror": "x"}, {"mirror": "y", "nodes": ["foot", "foot_m"], "suffix": "_b"}],
        "parts": {"foot_m_b": "leg"},
    }
    assert Figure.model_validate(figure).parts == {"foot_m_b": "leg"}
    figure["then"].append({"mirror": "x"})
    with pytest.raises(ValidationError, match="'foot_m', and there is one already; list the nodes"):
        Figure.model_validate(figure)


@pytest.mark.parametrize("name", ["a", "foot 1", "l-1", "Käfer", "1"])
def test_valid_node_names_are_accepted(name):
    assert Figure(nodes={name: [0, 0]}).nodes[name].at == (0, 0)


@pytest.mark.parametrize("name", ["", " a", "a ", "a.b", "a[0]", "a/b", "a\n", "-a", "x" * 65])
def test_invalid_node_names_are_refused(name):
    with pytest.raises(ValidationError):
        Figure(nodes={name: [0, 0]})
