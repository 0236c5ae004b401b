"""Specimens: for each entry of the library a scene that shows it, or lets it be heard.

It is what the library's picture and sound are made of, and what a new scene from it begins with.
Pictures and sounds are kept in the user's cache by all that they depend on.
"""

from __future__ import annotations

import contextlib
import hashlib
import threading
from collections.abc import Callable
from pathlib import Path

from pipeline.atomic_file import make_folder, write_if_changed
from pipeline.errors import UsageError
from pipeline.production.reports.figure_walk import walk_scene
from pipeline.production.run.take_stage import take_key
from pipeline.simulation.figure_analysis import build_figure
from pipeline.simulation.simulate import Simulation
from pipeline.simulation.take import Take
from pipeline.spec import Scene, library, read_scene
from pipeline.spec.name_catalogue import names_of
from pipeline.spec.terrain.scatter import Scatter
from pipeline.studio.figure_analysis import NAME
from pipeline.studio.figure_text import figure_of_text
from pipeline.studio.project import LIBRARY, Document
from pipeline.studio.scene_play import ScenePlay
from pipeline.terminal_text import escaped_line
from pipeline.user_cache import user_cache_folder

SIZE = (192, 108)
"""Of a picture [pixels]."""

MOMENT = 1.0
"""Of a scene's picture: it has begun by then [s]."""

HEAD = """\
# {text}
pronk: 1
title: "{title}"
fps: 24
duration: {duration}

terrain:
  kind: flat
  size: [20, 20]
  material: wood floor
  surroundings: none           # or forest, plain, sea, ...
  scatter: none                # no plants
"""

FILM = """\
light: studio
film: {preset: preview}
"""

MATERIAL = """\

cast:
  - {{name: ball, body: {{shape: sphere, radius: 0.3}}, at: [0, 0.65, -0.1], material: {name}}}
  - {{name: block, body: {{shape: cube, size: 0.5}}, at: [-0.75, 0.3, -0.35], material: {name}}}

camera: {{at: [0.6, 1.05, 2.4], look_at: [-0.35, 0.26, -0.2], fov_deg: 24}}
"""

DANCE = """\

cast:
  - {{name: anna, dancer: adult, dance: {name}}}

camera: {{at: [3.4, 1.35, 1.5], look_at: [0, 1.0, 0], fov_deg: 36}}
"""

VOICE = """\

cast:
  - {{name: bug, figure: beetle, scale: 0.6, walk: {{gait: tripod, speed: 0.7}}}}

camera: {{follow: bug, view: three-quarter}}
sound:
  ambience: none
  tempo_bpm: 96
  music:
    level_db: 6
    parts: {{own: {part}}}
    sections: {{bar: {{play: {{own: {notes}}}}}}}
    form: [bar]
    loop: true
  voices:
    - {{when: {{who: bug}}, {voice}}}    # in the score, and with a SoundFont in the track
"""

TEXTS: dict[str, tuple[str, str, float]] = {
    "material": ("A ball and a block of {name} fall on a wooden floor.", MATERIAL, 2),
    "dance": ("Somebody dances: {name}.", DANCE, 8),
    "instrument": (
        "A bar for {name}; in the score the feet of a beetle play it, too.",
        VOICE.replace("{part}", "{{instrument: {name}}}")
        .replace("{notes}", '"C4 E4 [G4 A4] C5"')
        .replace("{voice}", "instrument: {name}, pitch: by foot from C4, length: 0.5"),
        5,
    ),
    "drum": (
        "A bar for {name}; in the score the feet of a beetle play it, too.",
        VOICE.replace("{part}", "{{}}")
        .replace("{notes}", "{{drums: {{{name}: x..xx.X.}}}}")
        .replace("{voice}", "drum: {name}"),
        5,
    ),
}
"""Description, scene and duration [s] by kind of entry."""

MOMENTS = {"material": 1.8, "dance": 2.5}
"""Of the pictures of specimens [s]."""

SOUNDS = ("material", "instrument", "drum")
"""Kinds that are heard."""


def specimen_text(kind: str, name: str, folder: Path, title: str = "") -> str:
    """Return a scene that shows an entry of the library.

    Args:
        kind: a key of `TEXTS`.
        name: of the entry.
        folder: of the author, whose own dances are there too.
        title: of the scene; the entry's name if left out.

    Raises:
        UsageError: there is no such entry.
    """
    if kind not in TEXTS or name not in {entry.name for entry in names_of(f"{kind}s", folder)}:
        raise UsageError(f"the library has no {escaped_line(kind)} '{escaped_line(name)}'")
    text, scene, duration = TEXTS[kind]
    shown = (title or name.capitalize()).translate({ord(c): None for c in '"\\'})
    head = HEAD.format(text=text.format(name=name), title=shown, duration=f"{duration:g}")
    return head + scene.format(name=name) + FILM


class Specimens:
    """Pictures and sounds of the library.

    Args:
        read: returns a document by its name.
        folder: returns the author's folder.
    """

    def __init__(self, read: Callable[[str], Document], folder: Callable[[], Path]) -> None:
        self._read = read
        self._folder = folder
        # One at a time, so that what the author does meanwhile stays quick.
        self._turn = threading.Lock()
        self._take: Take | None = None

    def picture(self, kind: str, name: str) -> bytes:
        """Return a picture of an entry as PNG.

        Raises:
            PronkError: there is no such entry, or it cannot be shown.
        """
        scene, moment = self._shown(kind, name)

        def make() -> bytes:
            play = ScenePlay(scene, self._beginning(scene, moment), SIZE)
            return play.still(play.take.header.frames)

        return self._kept(scene, f"{moment}.png", make)

    def sound(self, kind: str, name: str) -> bytes:
        """Return the sound of an entry as WAV.

        Raises:
            PronkError: there is no such entry, or it cannot be heard.
        """
        if kind not in SOUNDS:
            raise UsageError(f"no sound stands for a {escaped_line(kind)}")
        scene = self._scene(specimen_text(kind, name, self._folder()))
        return self._kept(scene, "wav", lambda: ScenePlay(scene, self._whole(scene)).sound)

    def _shown(self, kind: str, name: str) -> tuple[Scene, float]:
        """Return the scene of an entry and the moment of its picture [s]."""
        if kind in MOMENTS:
            return self._scene(specimen_text(kind, name, self._folder())), MOMENTS[kind]
        document = self._read(name)
        if document.kind != kind:
            raise UsageError(f"'{escaped_line(name)}' is no {escaped_line(kind)}")
        if kind == "figure":
            config = figure_of_text(document.text)
            scene = walk_scene(build_figure(NAME, config, 1.0), config, {}, walks=False)
            return _bare(scene), 0.0
        return _bare(self._scene(document.text, name)), MOMENT

    def _scene(self, text: str, name: str = "") -> Scene:
        folder = library() if name.startswith(LIBRARY) else self._folder()
        return read_scene(text, "scene", folder)

    def _beginning(self, scene: Scene, moment: float) -> Take:
        """Return the take of a scene up to a moment."""
        simulation = Simulation(scene, take_key(scene))
        header = simulation.recorder.header
        frames = min(int(moment * float(header.rate)) + 1, header.frames)
        while not simulation.finished and simulation.step_number < frames * header.steps:
            simulation.step()
        take = simulation.take() if simulation.finished else simulation.take_so_far()
        assert take is not None, "a frame is whole"
        return take

    def _whole(self, scene: Scene) -> Take:
        """Return the take of a scene; the one before, where only the sound is another."""
        key = take_key(scene)
        if self._take is None or self._take.header.key != key:
            self._take = Simulation(scene, key).run(lambda _: None)
        return self._take

    def _kept(self, scene: Scene, suffix: str, make: Callable[[], bytes]) -> bytes:
        """Return what was made of a scene before, or make and keep it."""
        words = f"{take_key(scene)}|{SIZE}|{scene.model_dump_json(exclude_unset=True)}"
        digest = hashlib.blake2b(words.encode(), digest_size=16).hexdigest()
        file = user_cache_folder() / "studio" / f"{digest}.{suffix}"
        with self._turn:
            if file.is_file():
                return file.read_bytes()
            content = make()
            # Where nothing can be kept it is made again the next time.
            with contextlib.suppress(OSError):
                make_folder(file.parent)
                write_if_changed(file, content)
            return content


def _bare(scene: Scene) -> Scene:
    """Return a scene without plants and mountains, which take more time than all else."""
    bare = {"surroundings": "none", "edging": "none", "scatter": Scatter()}
    return scene.model_copy(update={"terrain": scene.terrain.model_copy(update=bare)})
