"""Every mistake is refused at its line and column, with a message that says what to write."""

from __future__ import annotations

from pathlib import Path

import pytest

from pipeline.errors import MAX_SHOWN, Problem, SceneError, located
from pipeline.spec import read_scene
from pipeline.spec.name_catalogue import names_of

GOOD = """\
pronk: 1
duration: 2
terrain: hills
figures:
  bug:
    nodes:
      head: [0, -1]
      hip: [0, 0]
      knee_l: [1, 0]
      foot_l: {at: [2, 0.5], radius: 0.1}
    chains: [[head, hip], [hip, knee_l, foot_l]]
    then: [{mirror: x, nodes: [knee_l, foot_l]}]
cast:
  - figure: bug
    walk: {speed: 0.5}
"""

LOOKS = "must be made of letters, digits, _ and, inside, - and blanks; is "
FPS = "should be a whole number 1 to 240, or text such as '30000/1001'"

LISTED = {
    kind: f" `pronk list {kind}` has all {len(names_of(kind, Path('no')))}"
    for kind in ("figures", "materials", "terrains", "lights", "causes")
}

# What is replaced in the good scene, by what (the mark § stands where the message must point),
# the path and the message.
ONE_MISTAKE = [
    # Keys.
    ("speed:", "§sped:", "cast[0].walk.sped", "unknown key, did you mean 'speed'?"),
    ("duration: 2", "duration: 2\n§zzz: 1", "zzz", "unknown key, known: camera, cast, dances, "
     "duration, figures, film, fps, frames, golden, light, materials, moods, places, pronk, "
     "rows_per_frame, script, seed, sound, steps, story, terrain, title, titles"),
    ("terrain: hills", "terrain: {kind: hills, §hight: 1}", "terrain.hight",
     "unknown key, did you mean 'height'?"),
    ("terrain: hills", "terrain: {kind: flat, §spacing: 1}", "terrain.spacing",
     "unknown key, known: at, cells, edging, foot_radius, footprints, heading_deg, kind, "
     "material, polygons, scatter, show_forbidden, size, surroundings, unsteppable_slope_deg, "
     "water"),
    ("[2, 0.5], radius", "[2, 0.5], §radios", "figures.bug.nodes.foot_l.radios",
     "unknown key, did you mean 'radius'?"),
    ("terrain: hills", "film: {§sise: [320, 180]}", "film.sise",
     "unknown key, did you mean 'size'?"),
    ("terrain: hills", "light: {sun: {§our: 12}}", "light.sun.our",
     "unknown key, did you mean 'hour'?"),
    ("terrain: hills", "sound: {voices: [{when: {who: 'b*', cause: §footfal}}]}",
     "sound.voices[0].when.cause", "nothing is caused by 'footfal', did you mean 'footfall'?"
     + LISTED["causes"]),
    ("terrain: hills", "sound: {voices: [{when: {who: §bgu}}]}", "sound.voices[0].when.who",
     "nobody in the cast is called 'bgu', did you mean 'bug'?"),
    ("terrain: hills", "sound: {detect: {squeak: {who: §bgu}}}", "sound.detect.squeak.who",
     "nobody in the cast is called 'bgu', did you mean 'bug'?"),
    ("terrain: hills", "sound: {voices: [{}, {when: {§caus: squeak}}]}",
     "sound.voices[1].when.caus", "unknown key, did you mean 'cause'?"),
    ("duration: 2", "duration: 2\ngolden: {frames: [1, §400]}", "golden.frames[1]",
     "the scene has frames 1-48, no 400"),
    ("terrain: hills", "§<<: {duration: 3}", "<<",
     "unknown key, known: camera, cast, dances, duration, figures, film, fps, frames, golden, "
     "light, materials, moods, places, pronk, rows_per_frame, script, seed, sound, steps, "
     "story, terrain, title, titles"),
    ("duration: 2", "duration: 2\n§duration: 2", "duration",
     "the key is repeated, it stands already on line 2"),
    ("{speed: 0.5}", "{speed: 0.5, cycle: 1, §speed: 0.5}", "cast[0].walk.speed",
     "the key is repeated, it stands already on line 15"),
    ("duration: 2", "duration: 2\n§1: 2", "", "a key must be text, is 1; put it in quotes"),
    ("duration: 2", "duration: 2\n§true: 2", "", "a key must be text, is true; put it in quotes"),
    ("duration: 2", "duration: 2\n? §[1, 2]\n: 2", "",
     "a key must be text, not a list or a mapping"),
    ("  - figure: bug\n    walk", "  - §walk", "cast[0].figure", "is missing"),
    ("pronk: 1\n", "§", "pronk", "is missing"),
    # Kinds of values.
    ("duration: 2", "duration: §fast", "duration", "should be a number, is the text 'fast'"),
    ("duration: 2", 'duration: §"2"', "duration", "should be a number, is the text '2'"),
    ("duration: 2", "duration: §true", "duration", "should be a number, is true"),
    ("duration: 2", "duration: §1_000", "duration", "should be a number, is the text '1_000'"),
    ("duration: 2", "duration: §1:30", "duration", "should be a number, is the text '1:30'"),
    ("duration: 2", "duration: §[2]", "duration", "should be a number, is a list of 1"),
    ("duration: 2", "duration: §{s: 2}", "duration", "should be a number, is a mapping"),
    ("duration: 2", "frames: §48.5", "frames", "should be a whole number, is 48.5"),
    ("duration: 2", "frames: §48.0", "frames", "should be a whole number, is 48.0"),
    ("terrain: hills", "seed: §yes", "seed", "should be a whole number, is the text 'yes'"),
    ("terrain: hills", "title: §3", "title", "should be text, is 3"),
    ("terrain: hills", "terrain: §3", "terrain", "should be a mapping of keys to values, is 3"),
    ("terrain: hills", "terrain: §{}", "terrain", "needs the key 'kind'"),
    ("terrain: hills", "materials: §[goo]", "materials",
     "should be a mapping of keys to values, is a list of 1"),
    ("walk: {speed: 0.5}", "walk: §fast", "cast[0].walk",
     "should be a mapping of keys to values, is the text 'fast'"),
    ("{speed: 0.5}", "{gait: §3}", "cast[0].walk.gait", "should be a name or a mapping, is 3"),
    ("terrain: hills", "camera: {follow: §3}", "camera.follow",
     "should be text or a list, is 3"),
    ("terrain: hills", "camera: {follow: [bug, §3]}", "camera.follow[1]", "should be text, is 3"),
    ("terrain: hills", "sound: {volume_db: §'3'}", "sound.volume_db",
     "should be a number, is the text '3'"),
    ("terrain: hills", "sound: {voices: [{mute: §yes}]}", "sound.voices[0].mute",
     "should be true or false, is the text 'yes'"),
    ("terrain: hills", "film: {size: [320, §x]}", "film.size[1]",
     "should be a whole number, is the text 'x'"),
    ("{speed: 0.5}", "{path: §[[0, 0]]}", "cast[0].walk.path",
     "leads nowhere, because the creature starts there; write another place, or leave `walk` out "
     "for one that stands"),
    ("[1, 0]", "§1", "figures.bug.nodes.knee_l",
     "should be a mapping of keys to values, is 1"),
    ("[1, 0]", "[1, §a]", "figures.bug.nodes.knee_l[1]", "should be a number, is the text 'a'"),
    ("[1, 0]", "§[1, 0, 0]", "figures.bug.nodes.knee_l",
     "must hold at most 2 values, holds 3"),
    ("[1, 0]", "§[1]", "figures.bug.nodes.knee_l", "must hold 2 values, holds 1"),
    ("pronk: 1", "pronk: §true", "pronk", "should be the number of the version, 1"),
    ("pronk: 1", "pronk: §1.0", "pronk", "should be the number of the version, 1"),
    ("pronk: 1", "pronk: §0", "pronk", "this pronk reads version 1 of the language, not 0"),
    ("pronk: 1", "pronk: §2", "pronk", "this pronk reads version 1 of the language, not 2"),
    ("terrain: hills", "camera: {at: §[1]}", "camera.at", "must hold 3 values, holds 1"),
    # Ranges.
    ("duration: 2", "duration: §-2", "duration", "must be greater than 0, is -2"),
    ("duration: 2", "duration: §0", "duration", "must be greater than 0, is 0"),
    ("duration: 2", "duration: §.nan", "duration", "must be a finite number, is .nan"),
    ("duration: 2", "duration: §.inf", "duration", "must be a finite number, is .inf"),
    ("duration: 2", "duration: §1e999", "duration", "the number is too large"),
    ("duration: 2", "duration: §9" + "9" * 400, "duration", "the number is too large"),
    ("duration: 2", "duration: §900000", "duration",
     "makes 21600000 frames, more than the 1000000 that are allowed"),
    ("duration: 2", "frames: §0", "frames", "must be greater than 0, is 0"),
    ("terrain: hills", "seed: §-1", "seed", "must be at least 0, is -1"),
    ("terrain: hills", "fps: §0", "fps", "must be from 1 to 240 frames a second, is 0"),
    ("terrain: hills", "fps: §241", "fps", "must be from 1 to 240 frames a second, is 241"),
    ("terrain: hills", "fps: §1/24", "fps", "must be from 1 to 240 frames a second, is 1/24"),
    ("terrain: hills", "fps: §24/0", "fps", FPS + ", is the text '24/0'"),
    ("terrain: hills", "fps: §24.5", "fps", FPS + ", is 24.5"),
    ("terrain: hills", "fps: §29.97", "fps",
     FPS + " ('30000/1001' is probably meant), is 29.97"),
    ("terrain: hills", "fps: §true", "fps", FPS + ", is true"),
    ("terrain: hills", "steps: §6", "steps",
     "must be a multiple of rows_per_frame, which is 4; is 6"),
    ("terrain: hills", "rows_per_frame: §3", "rows_per_frame",
     "must divide steps, which is 4; is 3"),
    ("terrain: hills", "terrain: {kind: flat, size: [3, §0]}", "terrain.size[1]",
     "must be greater than 0, is 0"),
    ("terrain: hills", "terrain: {kind: flat, cells: [§1, 9]}", "terrain.cells[0]",
     "must be at least 2, is 1"),
    ("terrain: hills", "terrain: {kind: flat, cells: [§4001, 2]}",
     "terrain.cells[0]", "must be at most 4000, is 4001"),
    ("terrain: hills", "terrain: {kind: flat, unsteppable_slope_deg: §90}",
     "terrain.unsteppable_slope_deg", "must be less than 90, is 90"),
    ("terrain: hills", "terrain: {kind: fractal, roughness: §1.01}", "terrain.roughness",
     "must be at most 1, is 1.01"),
    ("terrain: hills", "terrain: {kind: stairs, step_depth: §0.05}", "terrain.step_depth",
     "step_depth makes features of 0.05 m, less than 2 cells of 0.05 m along x; make that larger, "
     "or cells[0] at least 1200"),
    ("terrain: hills", "terrain: {kind: stones, gap: §0.01, jitter: 0}", "terrain.gap",
     "gap makes features of 0.01 m, less than 2 cells of 0.04 m along x and 2 cells of 0.04 m "
     "along z; make that larger, or cells at least [4000, 2400]"),
    ("terrain: hills", "terrain: {kind: ditches, spacing: §0.3}", "terrain.spacing",
     "spacing, 0.3, must be more than width, 0.3"),
    ("terrain: hills", "terrain: {kind: boulders, diameters: [0.5, §0.4]}",
     "terrain.diameters[1]", "0.4 is less than the diameter of the smallest, 0.5"),
    ("terrain: hills", "terrain: {kind: flat, at: [§1e5, 0]}", "terrain.at[0]",
     "must be at most 10000, is 100000.0"),
    ("terrain: hills", "terrain: {kind: flat, show_forbidden: §1}", "terrain.show_forbidden",
     "should be true or false, is 1"),
    ("terrain: hills", "terrain: {kind: flat, surroundings: §hils}", "terrain.surroundings",
     "must be 'auto', 'hills', 'mountains', 'forest', 'sea', 'plain', 'dunes', 'mesas' or "
     "'none', is the text 'hils'; did you mean 'hills'?"),
    ("terrain: hills", "terrain: {kind: flat, edging: §hegde}", "terrain.edging",
     "must be 'auto', 'hedge', 'wall', 'fence', 'railing', 'planters', 'houses', 'house', "
     "'school', 'overgrown', 'room' or 'none', is the text 'hegde'; did you mean 'hedge'?"),
    ("terrain: hills", "terrain: {kind: flat, scatter: §medow}", "terrain.scatter",
     "no scatter is called 'medow', did you mean 'meadow'? `pronk list scatter` has all 20"),
    ("terrain: hills", "terrain: {kind: flat, scatter: §fern}", "terrain.scatter",
     "'fern' is one species; write it in a list: [fern]"),
    ("terrain: hills", "terrain: hills\nlight: {sun: {hour: 9, clouds: §cirus}}",
     "light.sun.clouds",
     "no clouds are called 'cirus', did you mean 'cirrus'? `pronk list clouds` has all 6"),
    ("terrain: hills", "terrain: {kind: flat, scatter: [oak, §burch]}",
     "terrain.scatter[1]",
     "no species is called 'burch', did you mean 'birch'? `pronk list species` has all 35"),
    ("terrain: hills", "terrain: {kind: flat, scatter: {preset: meadow, §densty: 2}}",
     "terrain.scatter.densty", "unknown key, did you mean 'density'?"),
    ("terrain: hills", "terrain: {kind: flat, scatter: {preset: meadow, size: §40}}",
     "terrain.scatter.size", "must be at most 12, is 40"),
    ("terrain: hills", "terrain: §{kind: sum}", "terrain.of", "is missing"),
    ("terrain: hills", "terrain: {kind: sum, of: §[]}", "terrain.of",
     "must hold at least 1 value, holds 0"),
    ("terrain: hills", "terrain: {kind: sum, of: [flat, {preset: rocks, material: §sand}]}",
     "terrain.of[1].material", "belongs to the whole sum; write it beside 'of'"),
    ("terrain: hills", "terrain: {kind: sum, of: [{preset: rocks, size: §[9, 9]}]}",
     "terrain.of[0].size", "belongs to the whole sum; write it beside 'of'"),
    ("terrain: hills", "terrain: {kind: sum, of: [flat, §hils]}", "terrain.of[1]",
     "no terrain is called 'hils', did you mean 'hills'?" + LISTED["terrains"]),
    ("terrain: hills", "terrain: {kind: sum, of: [{preset: hills, §hight: 1}]}",
     "terrain.of[0].hight", "unknown key, did you mean 'height'?"),
    ("terrain: hills", "terrain: {kind: sum, size: [9, §-9], of: [hills]}", "terrain.size[1]",
     "must be greater than 0, is -9"),
    ("[1, 0]", "[§1e5, 0]", "figures.bug.nodes.knee_l[0]", "must be at most 10000, is 100000.0"),
    ("figure: bug", "figure: bug\n    scale: §0", "cast[0].scale", "must be greater than 0, is 0"),
    ("0.5}\n", "§-0.5}\n", "cast[0].walk.speed", "must be greater than 0, is -0.5"),
    ("terrain: hills", "film: {size: [320, §181]}", "film.size[1]",
     "must be a multiple of 2, is 181"),
    ("{speed: 0.5}", "{gait: {up: {l1: 0}, down: {l1: §1.5}}}", "cast[0].walk.gait.down.l1",
     "must be at most 1, is 1.5"),
    # Names.
    ("figure: bug", "figure: §bog", "cast[0].figure",
     "no figure is called 'bog', did you mean 'bug' or 'dog'?" + LISTED["figures"] +
     " (searched: this file, the library)"),
    ("figure: bug", "figure: §no/bug", "cast[0].figure",
     f"'no/bug' is no file: there is no folder {Path('no').resolve()}"),
    ("      hip: [0, 0]", "      hip: [0, 0]\n      §a.b: [3, 3]", "figures.bug.nodes.a.b",
     LOOKS + "the text 'a.b'"),
    ("walk: {speed: 0.5}", "name: a\n  - {figure: bug, name: §a}", "cast[1].name",
     "the name 'a' is taken by cast[0]"),
    ("walk: {speed: 0.5}", "name: §low_2\n  - {many: {layout: stack, count: 3, of: {shape: box}}, "
     "name: low}", "cast[0].name",
     "the name 'low_2' is taken by a body of cast[1], whose bodies are called low_1 to low_3"),
    ("{speed: 0.5}", "{§sped: 0.5}\n  - {many: {layout: stack, count: 3, of: die}, name: low}\n"
     "script: [{at: 0, who: bug, do: {look_at: low_1}}]", "cast[0].walk.sped",
     "unknown key, did you mean 'speed'?"),
    ("terrain: hills", "terrain: §hill", "terrain",
     "no terrain is called 'hill', did you mean 'hills'?" + LISTED["terrains"]),
    ("terrain: hills", "terrain: {kind: §hill}", "terrain.kind",
     "no kind is called 'hill', did you mean 'hills'?"),
    ("terrain: hills", "terrain: {preset: §hill}", "terrain.preset",
     "no terrain is called 'hill', did you mean 'hills'?" + LISTED["terrains"]),
    ("terrain: hills", "terrain: {preset: hills, §kind: hills}", "terrain.kind",
     "give either preset or kind, not both"),
    ("terrain: hills", "terrain: {kind: flat, material: §dry sail}", "terrain.material",
     "no material is called 'dry sail', did you mean 'dry soil'?" + LISTED["materials"]),
    ("figure: bug", "figure: bug\n    material: §gren chitin", "cast[0].material",
     "no material is called 'gren chitin', did you mean 'green chitin'?" + LISTED["materials"]),
    ("radius: 0.1", "material: §bown", "figures.bug.nodes.foot_l.material",
     "no material is called 'bown', did you mean 'bone'?" + LISTED["materials"]),
    ("  bug:\n", "  bug:\n    material: §bown\n", "figures.bug.material",
     "no material is called 'bown', did you mean 'bone'?" + LISTED["materials"]),
    ("terrain: hills", "light: §dai", "light", "no light is called 'dai', did you mean 'day'?"
     + LISTED["lights"]),
    ("terrain: hills", "camera: {follow: §bgu}", "camera.follow",
     "nobody in the cast is called 'bgu', did you mean 'bug'?"),
    ("terrain: hills", "camera: [{}, {start: 1, follow: [bug, §bgu]}]", "camera[1].follow[1]",
     "nobody in the cast is called 'bgu', did you mean 'bug'?"),
    ("terrain: hills", "camera: {view: §sid}", "camera.view",
     "must be 'three-quarter', 'side', 'front', 'back' or 'top', is the text 'sid'; "
     "did you mean 'side'?"),
    ("terrain: hills", "camera: {view: §400}", "camera.view", "must be at most 360, is 400"),
    ("terrain: hills", "camera: §atuo", "camera", "no camera is called 'atuo', did you mean "
     "'auto'? Others are mappings, such as {follow: bug}"),
    ("terrain: hills", "camera: {auto: §clam}", "camera.auto",
     "must be 'calm', 'natural' or 'quick', is the text 'clam'; did you mean 'calm'?"),
    ("terrain: hills", "camera: §{auto: true, view: side}", "camera",
     "`auto` conflicts with `view`; a director decides them, remove one"),
    ("terrain: hills", "camera: {auto: true, follow: §bgu}", "camera.follow",
     "nobody in the cast is called 'bgu', did you mean 'bug'?"),
    ("terrain: hills", "camera: {handheld: §2}", "camera.handheld", "must be at most 1, is 2"),
    ("{speed: 0.5}", "{gait: §trto}", "cast[0].walk.gait",
     "must be 'auto', 'trot', 'wave', 'tripod', 'ripple', 'walk', 'amble', 'pace', 'canter', "
     "'transverse gallop', 'rotary gallop', 'bound', 'run', 'hop' or 'skip', is the text 'trto'; "
     "did you mean 'trot'?"),
    ("{speed: 0.5}", "{duty: §1.5}", "cast[0].walk.duty",
     "must be at most 0.95, is 1.5"),
    ("{speed: 0.5}", "{gait: {up: {l1: 0, r1: 0.5}, §down: {l1: 0.5}}}", "cast[0].walk.gait.down",
     "lacks leg 'r1', which up has"),
    ("{speed: 0.5}", "{gait: {up: {l1: 0.5}, down: {l1: §0.5}}}", "cast[0].walk.gait.down.l1",
     "must differ from the foot-up phase"),
    # Figures.
    ("[head, hip]", "[§haed, hip]", "figures.bug.chains[0][0]",
     "no node is called 'haed', did you mean 'head'?"),
    ("[head, hip]", "[head, hip, §hip]", "figures.bug.chains[0][2]",
     "node 'hip' is connected to itself"),
    ("[head, hip]", "§[head]", "figures.bug.chains[0]", "a chain connects at least 2 nodes"),
    ("[[head, hip]", "[[head, §knee_m, hip]", "figures.bug.chains[0][1]",
     "no node is called 'knee_m', did you mean 'knee_l'?"),
    ("[head, hip], [hip,", "[head, hip], [§hip2, hip,", "figures.bug.chains[1][0]",
     "no node is called 'hip2', did you mean 'hip'?"),
    ("nodes: [knee_l, foot_l]", "nodes: [knee_l, §fot_l]", "figures.bug.then[0].nodes[1]",
     "no node is called 'fot_l', did you mean 'foot_l'?"),
    ("nodes: [knee_l, foot_l]", "nodes: [knee_l, §hip]", "figures.bug.then[0].nodes[1]",
     "node 'hip' lies on the axis, its copy would lie on itself"),
    ("nodes: [knee_l, foot_l]", "nodes: [knee_l, §knee_l]", "figures.bug.then[0].nodes[1]",
     "node 'knee_l' is listed twice"),
    ("foot_l]}]", "foot_l]}]\n    parts: {foot_r: leg, §foot_x: leg}", "figures.bug.parts.foot_x",
     "no node is called 'foot_x', did you mean 'foot_l' or 'foot_r'?"),
    ("foot_l]}]", "foot_l]}]\n    parts: {foot_r: §leag}", "figures.bug.parts.foot_r",
     "must be 'leg', 'arm', 'head', 'tail', 'feeler', 'horn', 'wing' or 'body', is the text "
     "'leag'; did you mean 'leg'?"),
    ("  bug:\n", "  bug:\n    style: §reptile\n", "figures.bug.style",
     "must be 'insect' or 'mammal', is the text 'reptile'"),
    # Words that contradict each other.
    ("duration: 2", "duration: 2\n§frames: 48", "frames",
     "give either duration or frames, not both"),
    ("pronk: 1\nduration: 2", "§pronk: 1", "", "give duration (in seconds) or frames"),
    ("{speed: 0.5}", "{speed: 0.9, cycle: 0.7, stride: §0.5}", "cast[0].walk.stride",
     "stride = speed * cycle, but 0.9 * 0.7 = 0.63, not 0.5; leave one of the three out, or take "
     "stride: 0.63, speed: 0.714285714 or cycle: 0.555555556"),
    ("terrain: hills", "camera: §{at: [1, 1, 1], view: side}", "camera",
     "`at` conflicts with `view`; remove one"),
    # What YAML can do and a scene cannot.
    ("duration: 2", "duration: §!!python/object/apply:os.system [id]", "duration",
     "the tag '!!python/object/apply:os.system' is refused: a file is plain data"),
    ("duration: 2", "duration: §!dice 6", "duration",
     "the tag '!dice' is refused: a file is plain data"),
    ("duration: 2", "duration: §!!timestamp 2001-01-01", "duration",
     "the tag '!!timestamp' is refused: a file is plain data"),
    ("duration: 2", "duration: §!!int two", "duration", "the value does not fit its tag '!!int'"),
    ("duration: 2", "duration: §!!int true", "duration", "the value does not fit its tag '!!int'"),
    ("duration: 2", "duration: 2\ntitle: §*nobody", "title",
     "there is no anchor '&nobody' before this alias"),
    ("duration: 2", "duration: 2\nfilm: &f {size: [2, §*f]}", "film.size[1]",
     "the alias '*f' would contain itself"),
]  # fmt: skip


def problems_in(text: str) -> tuple[Problem, ...]:
    with pytest.raises(SceneError) as caught:
        read_scene(text, "scene.yaml")
    return caught.value.problems


@pytest.mark.parametrize(("old", "new", "path", "message"), ONE_MISTAKE)
def test_one_mistake_is_one_problem_at_its_position(old, new, path, message):
    assert GOOD.count(old) == 1
    marked = GOOD.replace(old, new)
    before, mark, after = marked.partition("§")
    assert mark
    line, column = before.count("\n") + 1, len(before.rpartition("\n")[2]) + 1
    source = (before + after).split("\n")[line - 1]
    (problem,) = problems_in(before + after)
    assert (problem.path, problem.message) == (path, message)
    assert (problem.file, problem.line, problem.column) == ("scene.yaml", line, column)
    assert problem.source == (source if len(source) <= 200 else "")


def test_the_unchanged_scene_is_accepted():
    assert read_scene(GOOD).n_frames == 48


def test_a_problem_shows_its_line_with_a_caret():
    (problem,) = problems_in(GOOD.replace("speed:", "strde:"))
    assert str(problem) == (
        "scene.yaml:15:12: cast[0].walk.strde: unknown key, did you mean 'stride'?\n"
        "        walk: {strde: 0.5}\n"
        "               ^"
    )


def test_all_mistakes_are_reported_at_once_in_the_order_of_the_file():
    text = (
        GOOD.replace("duration: 2", "duration: -2")
        .replace("terrain: hills", "terrain: {kind: hills, material: mudd}\nfps: 0\nfps: 24")
        .replace("head: [0, -1]", "head: [0, .nan]")
        .replace("figure: bug", "figure: !x bug")
        .replace("speed:", "sped:")
        + "camera: {follow: nobody}\n"
    )
    found = [(p.line, p.path) for p in problems_in(text)]
    assert found == [
        (2, "duration"),
        (3, "terrain.material"),
        (4, "fps"),
        (5, "fps"),
        (9, "figures.bug.nodes.head[1]"),
        (16, "cast[0].figure"),
        (17, "cast[0].walk.sped"),
        (18, "camera.follow"),
    ]


def test_problems_are_in_file_order_after_a_syntax_error():
    assert [p.column for p in problems_in("[a, !x b]: 1\n*c\n")] == [1, 5, 1]


def test_figures_that_are_no_mapping_are_one_problem():
    text = "pronk: 1\nduration: 1\nfigures:\ncast: [{figure: bug}]\n"
    assert [(p.line, p.path) for p in problems_in(text)] == [(3, "figures")]


# Content of a whole file, and the line, column and message of the one problem with it.
WHOLE_FILES = [
    (b"", 0, 0, "is empty; the least that a file holds is 'pronk: 1'"),
    (b"# nothing\n", 0, 0, "is empty; the least that a file holds is 'pronk: 1'"),
    (b"\xef\xbb\xbf", 0, 0, "is empty; the least that a file holds is 'pronk: 1'"),
    (b"- pronk: 1\n", 1, 1, "should be a mapping of keys to values at the top"),
    (b"\n  pronk\n", 2, 3, "should be a mapping of keys to values at the top"),
    (b"pronk: 1\nbad: \xff\n", 2, 6, "is not UTF-8: the byte 0xff"),
    (b"\xff\xfep\x00", 1, 1, "is not UTF-8: the byte 0xff"),
    (b"pronk: 1\ntitle: a\x07\n", 2, 9, "is not YAML: the character U+0007 is not allowed"),
    (b"cast:\n\t- bug\n", 2, 1, "is not YAML: a tab cannot indent, use blanks"),
    (b"a: [1, 2\nb: 3\n", 2, 2,
     "is not YAML: expected ',' or ']', but got ':' (while parsing a flow sequence that began "
     "on line 1)"),
    (b"a: 'open\n", 2, 1,
     "is not YAML: found unexpected end of stream (while scanning a quoted scalar that began "
     "on line 1)"),
    (b'a: "\\UFFFFFFFF"\n', 1, 7, "is not YAML: a number or an escape is out of range"),
    (b"pronk: 1\n---\npronk: 1\n", 2, 1,
     "one file holds one document, and a second one begins here"),
    (b"a: " + b"[" * 48 + b"]" * 48, 1, 51, "lists and mappings go deeper than 48 levels"),
    (b"pronk: 2\nnew_word: 3\n", 1, 8, "this pronk reads version 1 of the language, not 2"),
    (b"#" * (8 * 2**20 + 1), 0, 0, "is larger than 8 MiB"),
]  # fmt: skip


@pytest.mark.parametrize(
    ("content", "line", "column", "message"), WHOLE_FILES, ids=range(len(WHOLE_FILES))
)
def test_a_file_that_is_no_scene_is_one_problem(content, line, column, message):
    with pytest.raises(SceneError) as caught:
        read_scene(content, "scene.yaml")
    (problem,) = caught.value.problems
    assert (problem.line, problem.column, problem.message) == (line, column, message)


def test_a_link_without_length_is_refused_at_its_end():
    text = GOOD.replace("[1, 0]", "[0, -0.0]")
    found = [(p.line, p.path, p.message) for p in problems_in(text)]
    assert found == [
        (
            11,
            "figures.bug.chains[1][1]",
            "nodes 'hip' and 'knee_l' are at the same place, so the link has no length",
        ),
        (
            12,
            "figures.bug.then[0].nodes[0]",
            "node 'knee_l' lies on the axis, its copy would lie on itself",
        ),
    ]


def test_an_alias_bomb_is_refused_at_its_line():
    levels = "\n".join(
        f"{name}: &{name} [{', '.join([f'*{below}'] * 10)}]"
        for below, name in zip("abcdefgh", "bcdefghi", strict=True)
    )
    (problem,) = problems_in("a: &a [1, 1, 1, 1, 1, 1, 1, 1, 1, 1]\n" + levels)
    assert problem.message == "holds more than 100000 values when its aliases are written out"
    assert problem.line == 5


def test_nesting_by_aliases_is_bounded():
    chain = "\n".join(f"a{i}: &a{i} [[[[[[*a{i - 1}]]]]]]" for i in range(1, 400))
    (problem,) = problems_in("a0: &a0 []\n" + chain)
    assert problem.message == "lists and mappings go deeper than 48 levels"


def test_aliases_within_bounds_are_accepted():
    text = GOOD.replace("[1, 0]", "&knee [1, 0]").replace("  - figure: bug", "  - figure: &f bug")
    scene = read_scene(text + "  - {figure: *f, at: *knee}\n")
    assert scene.cast[1].figure == "bug"
    assert scene.cast[1].at == (1.0, 0.0)


def test_yaml_1_1_booleans_are_text_and_core_tags_are_allowed():
    scene = read_scene(GOOD.replace("terrain: hills", "title: on\nseed: !!int 0x10\nfps: 25/1"))
    assert (scene.title, scene.seed, scene.rate) == ("on", 16, 25)


def test_the_rest_of_a_file_with_misspelt_keys_is_checked_in_the_same_round() -> None:
    problems = problems_in(
        "pronk: 1\nframes: 24\n"
        "terrain: {kind: stones, lenght: abc}\n"
        "cast: [{nmae: bug, figur: spider, walk: {}, pronk: {start: 2}}]\n"
        "script: [{when: {arived: bug}, who: bgu, do: stop}]\n"
    )
    assert [(p.path, p.message.split(",")[0]) for p in problems] == [
        ("terrain.lenght", "unknown key"),
        ("terrain.length", "should be a number"),
        ("cast[0].nmae", "unknown key"),
        ("cast[0].figur", "unknown key"),
        ("cast[0].pronk.start", "conflicts with walk"),
        ("script[0].when.arived", "unknown key"),
        ("script[0].who", "nobody in the cast is called 'bgu'"),
    ]
    both = problems_in(
        "pronk: 1\nframes: 24\ncast: [{figure: beetle}]\n"
        "terrain: {kind: stones, gap: 0.05, diameter: 0.1}\n"
    )
    assert [p.path for p in both] == ["terrain.gap", "terrain.diameter"]


def test_another_word_for_a_key_is_one_problem() -> None:
    (problem,) = problems_in("pronk: 1\nduration: 1\nperformers: [{figure: beetle, walk: {}}]\n")
    assert (problem.line, problem.path) == (3, "performers")
    assert problem.message == "unknown key, did you mean 'cast'?"


def test_of_many_problems_the_first_of_the_file_are_shown() -> None:
    problems = [Problem("cast", f"wrong {line}", "a.yaml", line, 1) for line in range(5000, 0, -1)]
    error = SceneError(problems)
    shown = [f"a.yaml:{line}:1: cast: wrong {line}" for line in range(1, MAX_SHOWN + 1)]
    for text in (str(error), located(error, "a.yaml")):
        assert text.splitlines() == [*shown, "and 4,980 more problems"]
    assert len(error.facts["problems"]) == 5000
    assert str(SceneError(problems[: MAX_SHOWN + 1])).splitlines()[-1] == "and 1 more problem"
    assert len(str(SceneError(problems[:MAX_SHOWN])).splitlines()) == MAX_SHOWN
