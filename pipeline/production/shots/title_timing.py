"""Title timing: the words of a scene's titles at a moment of its film."""

from __future__ import annotations

from collections.abc import Iterator

from pipeline.errors import Problem, SceneError
from pipeline.spec.scene import Scene
from render.config.titles import Title
from render.lettering import LEADING, Align, Lettering, text_extent

SAFE = 0.05
"""Border of the frame that titles keep free, in its width and height, as screens may cut it off."""

PLACES: dict[str, tuple[float, Align]] = {
    "middle": (0.5, "center"),
    "top": (0.5, "center"),
    "bottom": (0.5, "center"),
    "lower left": (SAFE + 0.02, "left"),
    "lower right": (1.0 - SAFE - 0.02, "right"),
}
"""Place across the frame, and how lines are aligned there."""

LOW, HIGH = 0.88, 0.12
"""Height from above of the last line below, and of the first one above."""


def text_of(title: Title, scene: Scene) -> str:
    """Return the words of a title, those of the scene where it has none of its own."""
    if title.text:
        return title.text.strip("\n")
    if not title.roll:
        return scene.title
    names = [member.name for member in scene.cast]
    return "\n".join([scene.title, "", "with", *names]).strip("\n")


def start_of(title: Title, scene: Scene) -> float:
    """Return when a title appears [s]."""
    if title.start is not None:
        return title.start
    length = float(scene.n_frames / scene.rate)
    return max(length - title.duration, 0.0) if title.roll else 0.0


def problems_of_titles(scene: Scene) -> Iterator[Problem]:
    """Yield what is wrong with the titles of a scene: no words, too wide, or after its end."""
    length = float(scene.n_frames / scene.rate)
    for i, title in enumerate(scene.titles):
        path, text = f"titles[{i}]", text_of(title, scene)
        if not text:
            yield Problem(path, "has no words: write text, or a title of the scene")
            continue
        if start_of(title, scene) >= length:
            yield Problem(f"{path}.start", f"the film ends at {length:g} s")
        frame = scene.film.resolved().size
        if not _fits(title, text, title.size, frame):
            # Letters are whole pixels wide: their width does not go straight by their size.
            steps = range(int(title.size * 1000.0), 0, -1)
            fits = next((k / 1000.0 for k in steps if _fits(title, text, k / 1000.0, frame)), 0.0)
            yield Problem(f"{path}.size", f"too large for these words, at most {fits:g} fits")


def require_titles(scene: Scene) -> None:
    """Refuse a scene with titles that cannot be shown.

    Raises:
        SceneError: with all that is wrong with them.
    """
    problems = list(problems_of_titles(scene))
    if problems:
        raise scene.source_map.with_locations(SceneError(problems))


def _fits(title: Title, text: str, size: float, frame: tuple[int, int]) -> bool:
    """Return whether words of a size stay clear of the frame's border, what rolls across alone."""
    wide, high = text_extent(text, title.font, size, frame)
    return wide <= 1.0 - 2.0 * SAFE and (title.roll or high <= 1.0 - 2.0 * SAFE)


def words_at(scene: Scene, time: float) -> tuple[Lettering, ...]:
    """Return the words over the picture at a time [s]."""
    return tuple(_words(scene, time))


def _words(scene: Scene, time: float) -> Iterator[Lettering]:
    for title in scene.titles:
        since = time - start_of(title, scene)
        if not 0.0 <= since < title.duration:
            continue
        fade = min(title.fade, 0.5 * title.duration)
        shown = min(since, title.duration - since) / fade if fade > 0.0 else 1.0
        text = text_of(title, scene)
        extent = LEADING * title.size * len(text.split("\n"))
        x, align = PLACES[title.place]
        y = {"middle": 0.5, "top": HIGH + 0.5 * (extent - LEADING * title.size)}.get(
            title.place, LOW - 0.5 * (extent - LEADING * title.size)
        )
        if title.roll:
            # From below the frame until the last line has left it above.
            y = 1.0 + 0.5 * extent - (1.0 + extent) * since / title.duration
            shown = 1.0
        yield Lettering(
            *(text, (x, round(y, 6)), align, title.size, title.font, title.color),
            opacity=round(min(shown, 1.0), 6),
            shadow=title.shadow,
        )
