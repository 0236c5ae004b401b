"""Scene play: the take of a scene as the page plays it, with its sound and rendered stills."""

from __future__ import annotations

import tempfile
import threading
from concurrent.futures import ThreadPoolExecutor
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from audio.wav_file import write_wav
from pipeline.errors import FilmingError, UsageError
from pipeline.production.gltf.take_file import take_glb
from pipeline.production.reports.plot_colors import cause_color
from pipeline.production.shots.shot_builder import ShotBuilder
from pipeline.production.sound.score_builder import build_score
from pipeline.simulation.node_names import NodeNames
from pipeline.simulation.take import Take, TerrainRecord
from pipeline.spec import Scene
from pipeline.studio.channel_curves import channel_facts
from pipeline.studio.walk import gait_bars
from pipeline.terminal_text import escaped_line
from render.backend import choose
from render.errors import RenderError
from render.image_files import write_png
from render.renderer import Renderer
from render.shot import Shot

STILL_SIZE = (480, 270)
"""Of a rendered still [pixels]."""


_RENDERING = ThreadPoolExecutor(1, "studio-stills")
"""One thread, because the renderer's variant belongs to the thread that chose it."""

_KEPT = threading.local()


class ScenePlay:
    """A scene that was simulated for the page.

    Args:
        scene: as its text has it.
        take: of the scene, or of its beginning.
        size: of stills [pixels].
    """

    def __init__(self, scene: Scene, take: Take, size: tuple[int, int] = STILL_SIZE) -> None:
        self.scene = scene.model_copy(
            update={"film": scene.film.model_copy(update={"preset": "draft", "size": size})}
        )
        self.take = take
        self._building = threading.Lock()

    @cached_property
    def facts(self) -> dict[str, Any]:
        """Length, events, stances and notes as plain values."""
        header = self.take.header
        step = float(header.rate * header.steps)
        events = [
            {
                "time": round((event.step + event.fraction) / step, 4),
                "cause": event.cause,
                "who": event.who,
                "place": [round(v, 3) for v in event.place],
                "strength": round(event.strength, 3),
                "color": cause_color(event.cause),
            }
            for event in self.take.events
        ]
        notes = [
            {"kind": note.kind, "time": round(note.step / step, 3), "text": note.text}
            for note in self.take.notes
        ]
        return {
            "title": header.title,
            "frames": header.frames,
            "fps": float(header.rate),
            "seconds": header.frames / float(header.rate),
            "events": events,
            "notes": notes,
            "gait": gait_bars(self.scene, self.take),
            "forbidden": forbidden_runs(self.take.terrain),
            "carriers": self._carriers(),
            "performers": list(dict.fromkeys(node.performer for node in self.take.nodes)),
        }

    def _carriers(self) -> dict[str, str]:
        """Return the nodes of what carries somebody, by how the text names it."""
        names = NodeNames.of(self.take)
        parents = {member.parent for member in self.scene.cast if member.parent is not None}
        found = {parent: names.find(parent) for parent in sorted(parents)}
        return {
            parent: self.take.nodes[number].name
            for parent, number in found.items()
            if isinstance(number, int)
        }

    def channels(self, performer: str) -> dict[str, Any]:
        """Return the channels and the mind of a performer over time.

        Raises:
            UsageError: there is no such performer.
        """
        if performer not in {node.performer for node in self.take.nodes}:
            raise UsageError(f"there is no performer '{escaped_line(performer)}'")
        return channel_facts(self.scene, self.take, performer)

    @cached_property
    def glb(self) -> bytes:
        """The take as binary glTF."""
        return take_glb(self.take, self.scene.materials)

    @cached_property
    def builder(self) -> ShotBuilder:
        """The shots of the take."""
        return ShotBuilder(self.scene, self.take)

    @cached_property
    def camera(self) -> list[list[float]]:
        """Origin, target [m] and field of view [degrees] of the film's camera, frame by frame."""
        return [
            [round(float(v), 4) for v in (*pose.p_WC, *pose.p_WT, pose.fov_deg)]
            for pose in self.builder.poses
        ]

    @cached_property
    def sound(self) -> bytes:
        """The sound track as WAV.

        Raises:
            PronkError: it cannot be made.
        """
        with self._building:
            score, _ = build_score(self.scene, self.take, self.builder.poses)
            with tempfile.TemporaryDirectory() as folder:
                path = Path(folder) / "sound.wav"
                write_wav(score, path)
                return path.read_bytes()

    def still(self, frame: int) -> bytes:
        """Return a frame by the film's renderer as PNG.

        Raises:
            UsageError: the scene has no such frame.
            FilmingError: it cannot be rendered.
        """
        if not 1 <= frame <= self.take.header.frames:
            raise UsageError(f"there is no frame {frame}; 1 to {self.take.header.frames}")
        try:
            with self._building:
                shot = self.builder.shot(frame)
            return _RENDERING.submit(_picture, shot).result()
        except RenderError as error:
            raise FilmingError(str(error)) from error


def forbidden_runs(terrain: TerrainRecord) -> dict[str, Any] | None:
    """Return the cells of a terrain without footholds as runs [row, from, to] along x.

    None where there are none, or where the terrain is no upright grid.
    """
    least, most = terrain.vertices.min(axis=0), terrain.vertices.max(axis=0)
    rows, columns = terrain.forbidden.shape
    is_grid = len(terrain.vertices) == (rows + 1) * (columns + 1)
    corners = terrain.vertices[[0, -1]][:, [0, 2]]
    if not terrain.forbidden.any() or not is_grid:
        return None
    if not np.allclose(corners, [least[[0, 2]], most[[0, 2]]]):
        return None
    runs = []
    for row, cells in enumerate(terrain.forbidden):
        edges = np.flatnonzero(np.diff(np.concatenate([[False], cells, [False]]).astype(int)))
        runs += [[row, int(start), int(end)] for start, end in edges.reshape(-1, 2)]
    size = (most - least)[[0, 2]] / (columns, rows)
    return {"corner": least[[0, 2]].tolist(), "cell": size.tolist(), "runs": runs}


def _picture(shot: Shot) -> bytes:
    """Return a shot as PNG."""
    if not hasattr(_KEPT, "renderer"):
        _KEPT.renderer = Renderer(choose("auto"))
    picture = _KEPT.renderer.render(shot).srgb8
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "still.png"
        write_png(path, picture, "still")
        return path.read_bytes()
