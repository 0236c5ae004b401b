"""Drawing operations: their effects, their laws, and refusals."""

from __future__ import annotations

import math
import random

import jsonschema
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from pipeline.errors import SceneError
from pipeline.spec import Figure, figure_schema, read_scene
from pipeline.spec.operations import OPERATIONS, Mirror
from pipeline.spec.operations.drawing_edits import copied_names, mirrored_name
from pipeline.spec.operations.node_selection import encloses

NODES = {"hip": [0, 0], "knee1_l": [-1, 0.2], "foot1_l": [-2, 0.5], "nose": [0, -1]}
CHAINS = [["nose", "hip", "knee1_l", "foot1_l"]]

# Every form of every operation; a test compares the keys with the registry.
FORMS = {
    "mirror": ["{mirror: x}", "{mirror: x, nodes: [knee1_l, foot1_l], suffix: _b}",
               "{mirror: y, nodes: [foot1_l]}"],
    "copy": ["{copy: [knee1_l, foot1_l], translate: [0, 1]}",
             "{copy: all, translate: [0, 3]}",
             "{copy: [foot1_l], rotate_deg: 30, about: hip, repeat: 3}",
             "{copy: [foot1_l], rotate_abs_deg: 30}",
             "{copy: [foot1_l], scale: 2, about: [0, 0]}",
             "{copy: [foot1_l], scale_xy: [2, 0.5], about: [1, 1]}",
             "{copy: [foot1_l], mirror: y}",
             "{copy: [hip], translate: [0, 1], repeat: 2, join: [[hip, hip]]}",
             "{copy: [hip], translate: [0, 1], join: []}"],
    "move": ["{move: [foot1_l], translate: [0, 1]}", "{move: all, rotate_deg: -90}",
             "{move: [nose, hip], scale: 0.5}", "{move: all, mirror: x}"],
    "select": ["{select: all}", "{select: none}", "{select: [hip]}",
               "{select: [[-3, -1], [-0.5, -1], [-0.5, 1], [-3, 1]]}"],
    "delete": ["{delete: [foot1_l]}"],
    "connect": ["{connect: [nose, knee1_l]}", "{connect: [nose, knee1_l, foot1_l]}"],
}  # fmt: skip


def figure_config(*then, nodes=NODES, chains=CHAINS, **more):
    operations = [yaml.safe_load(one) if isinstance(one, str) else one for one in then]
    return {"nodes": nodes, "chains": chains, "then": operations, **more}


def sheet_of(*then, **more):
    return Figure.model_validate(figure_config(*then, **more)).sheet()


def positions(sheet):
    return {name: pytest.approx(mark.at, abs=1e-9) for name, mark in sheet.marks.items()}


def test_every_operation_is_tested_here_and_implemented():
    assert OPERATIONS.keys() == FORMS.keys()
    assert all("apply" in vars(model) for model in OPERATIONS.values())


@pytest.mark.parametrize("form", [form for forms in FORMS.values() for form in forms])
def test_every_form_loads_and_fits_the_schema_and_its_operation(form):
    config = figure_config(form)
    assert jsonschema.Draft7Validator(figure_schema()).is_valid({"pronk": 1, "figure": config})
    figure = Figure.model_validate(config)
    (key,) = [key for key, model in OPERATIONS.items() if type(figure.then[0]) is model]
    assert form in FORMS[key]
    written = figure.model_dump(exclude_none=True)
    assert Figure.model_validate(written) == figure


# What operations do.


def test_mirror_copies_nodes_beside_the_axis_with_their_connections():
    sheet = sheet_of("{mirror: x}")
    assert sheet.marks["foot1_r"].at == (2.0, 0.5)
    assert {("hip", "knee1_r"), ("foot1_r", "knee1_r")} <= sheet.connections
    assert len(sheet.connections) == 5
    assert sheet_of("{mirror: y, nodes: [foot1_l]}").marks["foot1_r"].at == (-2.0, -0.5)


def test_mirrored_names_swap_their_side():
    assert mirrored_name("foot_l") == "foot_r"
    assert mirrored_name("foot_r") == "foot_l"
    assert mirrored_name("foot1") == "foot1_m"
    assert mirrored_name("foot1", "_back") == "foot1_back"


@given(st.from_regex(r"[a-z]{1,5}(_l|_r)", fullmatch=True))
def test_mirroring_a_name_twice_restores_it(name):
    assert mirrored_name(mirrored_name(name)) == name


@pytest.mark.parametrize(
    ("name", "copies"),
    [
        ("leg1_l", ["leg2_l", "leg3_l"]),
        ("hip_r", ["hip_2_r", "hip_3_r"]),
        ("tail", ["tail_2", "tail_3"]),
        ("seg9", ["seg10", "seg11"]),
        ("7", ["8", "9"]),
        ("_l", ["_2_l", "_3_l"]),
    ],
)
def test_copies_are_numbered(name, copies):
    taken = {name}
    for copy in copies:
        assert copied_names([name], taken) == {name: copy}
        taken.add(copy)
        name = copy


def test_numbers_in_use_are_skipped():
    assert copied_names(["f1", "f2", "f3"], ["f1", "f2", "f3"]) == {
        "f1": "f4", "f2": "f5", "f3": "f6"
    }  # fmt: skip


def test_copies_keep_the_connections_of_their_originals():
    sheet = sheet_of("{copy: [knee1_l, foot1_l], rotate_deg: 40, about: hip, repeat: 2}")
    assert set(sheet.marks) == {*NODES, "knee2_l", "foot2_l", "knee3_l", "foot3_l"}
    assert {("hip", "knee2_l"), ("hip", "knee3_l"), ("foot3_l", "knee3_l")} <= sheet.connections
    assert ("knee2_l", "knee3_l") not in sheet.connections


def test_joined_copies_of_a_segment_form_a_centipede():
    nodes = {"head": [0, -1], "seg1": [0, 0], "hip1_l": [-0.2, 0], "foot1_l": [-1, 0.1]}
    copy = "{copy: [seg1, hip1_l, foot1_l], translate: [0, 0.5], repeat: 9, join: [[seg1, seg1]]}"
    sheet = sheet_of(copy, "{mirror: x}", nodes=nodes, chains=[[*nodes]])
    assert len(sheet.marks) == 1 + 10 * 5
    assert {("seg1", "seg2"), ("seg10", "seg9")} <= sheet.connections
    assert [pair for pair in sheet.connections if "head" in pair] == [("head", "seg1")]
    assert sheet.marks["foot10_r"].at == pytest.approx((1, 4.6))
    assert len(sheet.connections) == 1 + 9 + 10 * 4


def test_a_copy_may_be_disconnected_and_connected_later():
    loose = sheet_of("{copy: [hip], translate: [0, 1], join: []}")
    assert len(loose.connections) == 3
    tied = sheet_of("{copy: [hip], translate: [0, 1], join: []}", "{connect: [hip, hip_2]}")
    assert tied.connections - loose.connections == {("hip", "hip_2")}


def test_transformations_apply_in_order():
    sheet = sheet_of(
        "{move: [foot1_l], mirror: x, scale: 2, rotate_deg: 90, translate: [10, 0], about: [0, 0]}"
    )
    # Mirrored to (2, 0.5), scaled to (4, 1), turned to the left to (1, -4), moved by 10.
    assert sheet.marks["foot1_l"].at == pytest.approx((11, -4))
    assert sheet.marks["foot1_l"].size == 2


def test_rotation_is_to_the_left_about_the_centre_by_default():
    pair = {"a": [1, 0], "b": [3, 0], "c": [9, 9]}
    sheet = sheet_of("{move: [a, b], rotate_deg: 90}", nodes=pair, chains=[])
    assert positions(sheet)["b"] == (2, -1), "right turns to the front"
    sheet = sheet_of("{move: [a, b], rotate_abs_deg: 90}", nodes=pair, chains=[])
    assert positions(sheet)["b"] == (0, -3)


def test_scaling_scales_radii():
    sheet = sheet_of("{move: all, scale_xy: [4, 1]}")
    assert {mark.size for mark in sheet.marks.values()} == {2}


def test_previous_selection_alternates_between_the_last_two():
    outline = "{select: [[-3, -1], [-0.5, -1], [-0.5, 1], [-3, 1]]}"
    back = "{select: previous}"
    first, second = ("knee1_l", "foot1_l"), ("hip",)
    assert sheet_of(outline).selected == first
    assert sheet_of(outline, "{select: [hip]}").selected == second
    assert sheet_of(outline, "{select: [hip]}", back).selected == first
    assert sheet_of(outline, "{select: [hip]}", back, back).selected == second
    assert sheet_of(outline, "{select: none}").selected == ()
    assert sheet_of(outline, "{select: none}", back).selected == first
    assert sheet_of("{select: all}").selected == tuple(NODES)
    assert sheet_of(outline, "{delete: [foot1_l]}").selected == ("knee1_l",)


def test_operations_work_on_the_selection():
    legs = "{select: [knee1_l, foot1_l]}"
    by_name = sheet_of("{mirror: x, nodes: [knee1_l, foot1_l]}")
    assert sheet_of(legs, "{mirror: x, nodes: selected}").marks.keys() == by_name.marks.keys()
    assert set(sheet_of(legs, "{delete: selected}").marks) == {"hip", "nose"}
    copied = sheet_of(legs, "{copy: selected, translate: [0, 1]}")
    assert {"knee2_l", "foot2_l"} <= set(copied.marks)


def test_nodes_near_an_axis_snap_to_it():
    nodes = {"a": [1e-3, -1], "b": [-1e-3, 1], "c": [0.1, 1e-3]}
    assert [m.at for m in sheet_of(nodes=nodes, chains=[]).marks.values()] == [
        (0, -1), (0, 1), (0.1, 0)
    ]  # fmt: skip
    kept = sheet_of(nodes=nodes, chains=[], sticky=0.0)
    assert kept.marks["a"].at == (1e-3, -1)
    assert sheet_of(nodes=nodes, chains=[], sticky=0.2).marks["c"].at == (0, 0)
    moved = sheet_of("{move: [c], translate: [-0.099, 1]}", nodes=nodes, chains=[])
    assert moved.marks["c"].at[0] == 0


# Laws.


coordinates = st.floats(-5, 5).map(lambda x: round(x, 3))
points = st.tuples(coordinates, coordinates)
drawings = st.lists(points, min_size=1, max_size=8, unique=True).map(
    lambda found: {f"n{i}": list(at) for i, at in enumerate(found)}
)


@given(drawings, st.sampled_from("xy"))
def test_mirroring_twice_is_the_identity(nodes, axis):
    move = {"move": "all", "mirror": axis}
    assert positions(sheet_of(nodes=nodes, chains=[])) == {
        name: mark.at for name, mark in sheet_of(move, move, nodes=nodes, chains=[]).marks.items()
    }


@given(points, st.sampled_from("xy"))
def test_a_mirror_of_a_mirror_lies_on_the_original(at, axis):
    sheet = sheet_of(nodes={"a_l": [3 + abs(at[0]), 3 + abs(at[1])]}, chains=[])
    once, faults = Mirror(mirror=axis).apply(sheet)
    assert not faults
    alone = once.__class__({"a_r": once.marks["a_r"]})
    twice, _ = Mirror(mirror=axis).apply(alone)
    assert twice.marks["a_l"].at == sheet.marks["a_l"].at


@given(drawings, st.integers(2, 24), st.sampled_from(["rotate_deg", "rotate_abs_deg"]))
def test_partial_rotations_of_a_full_turn_are_the_identity(nodes, n, word):
    sheet = sheet_of(*[{"move": "all", word: 360 / n}] * n, nodes=nodes, chains=[], sticky=0)
    assert positions(sheet) == {name: tuple(at) for name, at in nodes.items()}


@given(drawings, points, st.floats(0.1, 8), st.floats(-720, 720))
def test_inverse_transformations_are_the_identity(nodes, sense, factor, angle):
    back = [-sense[0], -sense[1]]
    about = list(sense)
    sheet = sheet_of(
        {"move": "all", "translate": list(sense)},
        {"move": "all", "scale": factor, "rotate_deg": angle, "about": about},
        {"move": "all", "scale": 1 / factor, "rotate_deg": -angle, "about": about},
        {"move": "all", "translate": back},
        nodes=nodes, chains=[], sticky=0,
    )  # fmt: skip
    assert {n: pytest.approx(m.at, abs=1e-7) for n, m in sheet.marks.items()} == {
        name: tuple(at) for name, at in nodes.items()
    }
    assert all(mark.size == pytest.approx(1) for mark in sheet.marks.values())


@given(drawings, points, st.integers(1, 4))
def test_deleting_all_copies_restores_the_drawing(nodes, sense, n):
    chain = [[*nodes]] if len(nodes) > 1 else []
    move = [sense[0] + 20, sense[1]]
    before = sheet_of(nodes=nodes, chains=chain, sticky=0)
    copy = {"copy": "all", "translate": move, "repeat": n}
    copied = sheet_of(copy, nodes=nodes, chains=chain, sticky=0)
    made = [name for name in copied.marks if name not in nodes]
    assert len(made) == n * len(nodes)
    after = sheet_of(copy, {"delete": made}, nodes=nodes, chains=chain, sticky=0)
    assert (after.marks, after.connections) == (before.marks, before.connections)


@given(drawings, points, st.integers(1, 4))
def test_repeat_equals_copying_the_last_copy(nodes, sense, n):
    move = {"translate": [sense[0] + 20, sense[1]], "rotate_deg": 7}
    once = sheet_of({"copy": "all", **move, "repeat": n}, nodes=nodes, chains=[])
    last, then = list(nodes), []
    taken = set(nodes)
    for _ in range(n):
        then.append({"copy": last, **move})
        last = list(copied_names(last, taken).values())
        taken |= set(last)
    assert positions(once) == {
        k: m.at for k, m in sheet_of(*then, nodes=nodes, chains=[]).marks.items()
    }


# The enclosure test.

C_SHAPE = [(0, 0), (4, 0), (4, 1), (1, 1), (1, 3), (4, 3), (4, 4), (0, 4)]
STAR = [(math.cos(0.8 * math.pi * k), math.sin(0.8 * math.pi * k)) for k in range(5)]


@pytest.mark.parametrize("sense", [1, -1], ids=["one sense", "other sense"])
@pytest.mark.parametrize(
    ("outline", "point", "inside"),
    [
        ([(0, 0), (1, 0), (0, 1)], (0.2, 0.2), True),
        ([(0, 0), (1, 0), (0, 1)], (0.6, 0.6), False),
        (C_SHAPE, (0.5, 2), True),
        (C_SHAPE, (2.5, 2), False),
        (C_SHAPE, (3.5, 0.5), True),
        (C_SHAPE, (-1, 2), False),
        ([(0, 0), (1, 0), (1, 1), (0, 1), (0, 0)], (0.5, 0.5), True),  # first point repeated
        ([(0, 0), (1, 0), (1, 1), (0, 1)], (0.5, 0), True),  # on the outline
        ([(0, 0), (1, 0), (1, 1), (0, 1)], (0, 0), True),  # on a corner
        (STAR, (0, 0), True),  # wound around twice
        (STAR, (0.9, 0.6), False),
    ],
)
def test_outlines_enclose_known_points(outline, point, inside, sense):
    assert encloses(outline[::sense], point) is inside


def encloses_by_crossings(outline, point):
    """Return whether a ray to the right crosses the outline an odd number of times."""
    x, y = point
    odd = False
    for (ax, ay), (bx, by) in zip(outline, [*outline[1:], outline[0]], strict=True):
        if (ay > y) != (by > y) and x < ax + (y - ay) * (bx - ax) / (by - ay):
            odd = not odd
    return odd


@settings(max_examples=300)
@given(st.integers(0, 2**32), st.integers(3, 30))
def test_enclosure_matches_counting_of_crossings(seed, n):
    draw = random.Random(seed)
    # A star-shaped outline never crosses itself, and is concave nearly always.
    angles = sorted(draw.uniform(0, 2 * math.pi) for _ in range(n))
    radii = [draw.uniform(0.1, 3) for _ in range(n)]
    outline = [(r * math.cos(a), r * math.sin(a)) for r, a in zip(radii, angles, strict=True)]
    if draw.random() < 0.5:
        outline.reverse()
    for _ in range(20):
        point = draw.uniform(-3, 3), draw.uniform(-3, 3)
        assert encloses(outline, point) == encloses_by_crossings(outline, point)


# What is refused, and where.

SCENE = """\
pronk: 1
duration: 2
figures:
  bug:
    nodes: {head: [0, -1], hip: [0, 0], knee_l: [-1, 0], foot_l: [-2, 0.5]}
    chains: [[head, hip, knee_l, foot_l]]
    then:
      - {mirror: x}
      - OPERATION
cast: [{figure: bug}]
"""

MISTAKES = [
    ("{§copi: [hip], translate: [0, 1]}", ".copi", "no operation is called 'copi', did you mean"
     " 'copy'?"),
    ("{§nodes: [hip]}", ".nodes", "no operation is called 'nodes', known: connect, copy, delete, "
     "mirror, move, select"),
    ("§[copy]", "", "should be a mapping with one of the keys copy, move, select, delete, "
     "connect, mirror"),
    ("{copy: [§hipp], translate: [0, 1]}", ".copy[0]", "no node is called 'hipp', did you mean "
     "'hip'?"),
    ("{copy: [hip, §knee_m], translate: [0, 1]}", ".copy[1]", "no node is called 'knee_m', did "
     "you mean 'knee_l' or 'knee_r'?"),
    ("{copy: §hip, translate: [0, 1]}", ".copy", "must be 'selected' or 'all', is the text 'hip'"),
    ("{copy: [hip], §trnslate: [0, 1]}", ".trnslate", "unknown key, did you mean 'translate'?"),
    ("{copy: [hip], translate: §[0]}", ".translate", "must hold 2 values, holds 1"),
    ("{copy: [hip], rotate_deg: §a}", ".rotate_deg", "should be a number, is the text 'a'"),
    ("§{copy: [hip]}", "", "moves nothing; give one of mirror, scale, scale_xy, rotate_deg, "
     "rotate_abs_deg, translate"),
    ("{copy: [foot_l], rotate_deg: 4, about: §hipp}", ".about", "no node is called 'hipp', did "
     "you mean 'hip'?"),
    ("{copy: [foot_l], scale: §0}", ".scale", "must be at least 0.001, is 0"),
    ("{copy: [foot_l], translate: [0, 1], repeat: §999}", ".repeat", "would make 1005 nodes; a "
     "drawing has at most 1000"),
    ("{copy: [foot_l], translate: [0, 1], join: [[foot_l, §hip]]}", ".join[0][1]",
     "no node called 'hip' is copied here, known: foot_l"),
    ("{copy: [foot_l], translate: [0, 1], join: [[§fot_l, foot_l]]}", ".join[0][0]",
     "no node is called 'fot_l', did you mean 'foot_l'?"),
    ("§{copy: [foot_l], translate: [9000, 0], repeat: 2}", "", "node 'foot_3_l' would lie beyond "
     "10000 m, or be too small or too large"),
    ("§{move: [knee_l], translate: [1, 0]}", "", "nodes 'hip' and 'knee_l' are at the same place, "
     "so the link has no length"),
    ("{move: §selected, translate: [1, 0]}", ".move", "no node is selected here; write a select "
     "before it"),
    ("{select: §previous}", ".select", "nothing was selected before"),
    ("{select: §[[9, 9], [8, 9], [8, 8]]}", ".select", "there is no node inside this outline"),
    ("{select: §[[9, 9], [8, 9]]}", ".select", "must hold at least 3 values, holds 2"),
    ("{select: [§hedd]}", ".select[0]", "no node is called 'hedd', did you mean 'head'?"),
    ("{delete: §all}", ".delete", "would leave no node"),
    ("{delete: [hip, §hip]}", ".delete[1]", "node 'hip' is listed twice"),
    ("{connect: [hip, §fot_r]}", ".connect[1]", "no node is called 'fot_r', did you mean "
     "'foot_r'?"),
    ("{connect: §[hip]}", ".connect", "a chain connects at least 2 nodes"),
    ("{connect: [hip, §hip]}", ".connect[1]", "node 'hip' is connected to itself"),
    ("{mirror: x, nodes: §selected}", ".nodes", "no node is selected here; write a select "
     "before it"),
    ("{mirror: y, §node: [head]}", ".node", "unknown key, did you mean 'nodes'?"),
]  # fmt: skip


@pytest.mark.parametrize(("operation", "path", "message"), MISTAKES)
def test_one_mistake_is_one_problem_at_its_position(operation, path, message):
    before, _, after = SCENE.replace("OPERATION", operation).partition("§")
    with pytest.raises(SceneError) as caught:
        read_scene(before + after, "bug.yaml")
    (problem,) = caught.value.problems
    assert (problem.path, problem.message) == (f"figures.bug.then[1]{path}", message)
    column = len(before.rpartition("\n")[2]) + 1
    assert (problem.line, problem.column) == (before.count("\n") + 1, column)


def test_operations_after_a_mistake_are_checked():
    figure = figure_config(
        "{copy: [hip, hipp], translate: [0, 1]}", "{delete: [hip_2]}", "{delete: [hip_3]}"
    )
    text = yaml.safe_dump(
        {"pronk": 1, "duration": 1, "figures": {"a": figure}, "cast": [{"figure": "a"}]}
    )
    with pytest.raises(SceneError) as caught:
        read_scene(text)
    assert [p.path for p in caught.value.problems] == [
        "figures.a.then[0].copy[1]", "figures.a.then[2].delete[0]"
    ]  # fmt: skip
