"""App: the routes of the studio, each a thin layer over the readers and reports of the commands.

Figures are analysed and scenes simulated in threads, so that the page is answered meanwhile.
"""

from __future__ import annotations

import importlib.resources
import json
import threading
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from functools import lru_cache
from pathlib import Path
from typing import Any, get_args

from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from pipeline.errors import PronkError, SceneError, UsageError
from pipeline.production.run.starter_scene import write_starter
from pipeline.production.run.take_stage import take_key
from pipeline.simulation.simulate import Simulation
from pipeline.spec import Figure, Scene, figure_schema, read_scene, schema
from pipeline.spec.figure import PartKind
from pipeline.spec.name_catalogue import names_of
from pipeline.spec.scene_library import FIGURES
from pipeline.studio.access import Guard
from pipeline.studio.drawing import DrawnFigure
from pipeline.studio.figure_analysis import analysed, drawn_text, problem_facts, with_drawing
from pipeline.studio.figure_text import NEW_FIGURE, figure_of_text, updated_text
from pipeline.studio.first_frames import FirstFrames, Requested
from pipeline.studio.newest import Newest, Superseded
from pipeline.studio.project import Document, Project, kind_of
from pipeline.studio.render_queue import PRESETS, RenderQueue
from pipeline.studio.scene_play import ScenePlay
from pipeline.studio.specimens import TEXTS, Specimens, specimen_text
from pipeline.studio.walk import figure_walk

PAGE = importlib.resources.files("pipeline.studio") / "page"

ASSETS = {
    "studio.js": "text/javascript; charset=utf-8",
    "studio.css": "text/css; charset=utf-8",
    "licences.txt": "text/plain; charset=utf-8",
}
"""Files of the page by their type; no others are served."""

Json = dict[str, Any]


MAX_PAGES = 4
"""Pages whose takes are kept; opening another one forgets that used longest ago."""


@dataclass(slots=True)
class OpenPage:
    """What one page of the browser simulates and shows.

    Attributes:
        walks: simulations of a drawn figure.
        takes: simulations of a scene.
        play: number and play of the scene that is shown.
        first: first frames of what is being simulated.
    """

    walks: Newest = field(default_factory=Newest)
    takes: Newest = field(default_factory=Newest)
    play: tuple[int, ScenePlay] | None = None
    first: Requested = field(default_factory=Requested)

    def stop(self) -> None:
        """End what is being simulated."""
        self.walks.stop()
        self.takes.stop()


@dataclass(slots=True)
class Studio:
    """What is open in the browser.

    Attributes:
        project: folder of documents.
        first: name of the document that is shown first, None for a new figure.
        token: of the address.
    """

    project: Project
    first: str | None
    token: str
    _pages: dict[str, OpenPage] = field(default_factory=dict)
    _opening: threading.Lock = field(default_factory=threading.Lock)
    _plays: int = 0
    _queue: RenderQueue = field(init=False)
    _specimens: Specimens = field(init=False)

    def __post_init__(self) -> None:
        self._queue = RenderQueue(lambda: self.project.folder)
        self._specimens = Specimens(
            lambda name: self.project.read(name), lambda: self.project.folder
        )

    def stop(self) -> None:
        """End what is being simulated and rendered."""
        with self._opening:
            pages = list(self._pages.values())
        for page in pages:
            page.stop()
        self._queue.stop_all()

    def _page(self, message: Json) -> OpenPage:
        """Return the page that sent a message, which is then the one used last."""
        name = message.get("page", "")
        if not isinstance(name, str):
            raise UsageError("`page` is no text")
        with self._opening:
            page = self._pages.pop(name, None) or OpenPage()
            self._pages[name] = page
            if len(self._pages) > MAX_PAGES:
                self._pages.pop(next(iter(self._pages))).stop()
        return page

    def library(self, _: Json) -> Json:
        """Return the documents of the project and of the library, and its other entries."""
        entries = [
            {"kind": kind, **asdict(entry)}
            for kind in TEXTS
            for entry in names_of(f"{kind}s", self.project.folder)
        ]
        return {"documents": self.project.listed(), "entries": entries, "first": self.first}

    def picture(self, message: Json) -> Response:
        """Return a picture of an entry of the library as PNG."""
        content = self._specimens.picture(_text(message, "kind"), _text(message, "name"))
        return Response(content, media_type="image/png")

    def heard(self, message: Json) -> Response:
        """Return the sound of an entry of the library as WAV."""
        content = self._specimens.sound(_text(message, "kind"), _text(message, "name"))
        return Response(content, media_type="audio/wav")

    def new_from(self, message: Json) -> Json:
        """Write a copy of a document, or a scene with another entry, into the project."""
        kind, source = _text(message, "kind"), _text(message, "source")
        stem = _text(message, "name").removesuffix(".yaml")
        if kind in TEXTS:
            title = stem.replace("_", " ").capitalize()
            text = specimen_text(kind, source, self.project.folder, title)
        else:
            text = self.project.read(source).text
        name = f"{FIGURES}/{stem}.yaml" if kind_of(text) == "figure" else f"{stem}.yaml"
        return _document(self.project.read(self.project.write(name, text)))

    def open(self, message: Json) -> Json:
        """Return a document; of a figure, with its drawing and what is wrong with it."""
        if message.get("name") is None:
            return _document(Document("", "figure", NEW_FIGURE, False))
        return _document(self.project.read(_text(message, "name")))

    def check(self, message: Json) -> Json:
        """Return the drawing of a figure's text and its problems; a wrong scene is refused."""
        text = _text(message, "text")
        if message.get("kind") == "scene":
            read_scene(text, "scene", self._folder(message))
            return {"problems": []}
        return _drawing_of(text, "figure")

    def analyse(self, message: Json) -> Json:
        """Return what a drawing becomes."""
        return analysed(self._figure(message), not message.get("is_moving"))

    def walk(self, message: Json) -> Response:
        """Return the walk of a drawing as binary glTF, its facts in a header."""
        config = self._figure(message)
        made = self._page(message).walks.run(lambda wanted: figure_walk(config, {}, wanted))
        return _glb(made.glb, made.facts)

    def text_of(self, message: Json) -> Json:
        """Return the text of a figure file with a drawing in it."""
        drawing, text = DrawnFigure.from_json(message.get("drawing")), _text(message, "text")
        is_empty = text == NEW_FIGURE and not drawing.nodes
        return {"text": text if is_empty else updated_text(text, drawing)}

    def save(self, message: Json) -> Json:
        """Write a document; return it as it is then."""
        text = _text(message, "text")
        if message.get("drawing") is not None:
            text = updated_text(text, DrawnFigure.from_json(message["drawing"]))
        before = message.get("before")
        if before is not None and not isinstance(before, str):
            raise UsageError("`before` is no text")
        name = self.project.write(_text(message, "name"), text, before)
        return _document(self.project.read(name))

    def take(self, message: Json) -> Json:
        """Simulate the text of a scene; return its facts and the number to ask for more with."""
        scene = read_scene(_text(message, "text"), "scene", self._folder(message))
        first, page = FirstFrames(scene), self._page(message)
        page.first.put(message.get("request"), first)
        try:
            play = page.takes.run(lambda wanted: _played(page, scene, wanted, first))
        finally:
            first.end()
        with self._opening:
            self._plays += 1
            number = self._plays
            page.play = number, play
        return {"play": number, **play.facts}

    def first_frames(self, message: Json) -> Response:
        """Return the first frames of a take that is being made as binary glTF, and their length."""
        after = message.get("after", 0)
        if not isinstance(after, int):
            raise UsageError("`after` is no number of frames")
        beginning = self._page(message).first.get(message.get("request")).wait(after)
        return _glb(beginning.glb, beginning.facts)

    def channels(self, message: Json) -> Json:
        """Return the channels of a performer over time."""
        return self._shown(message).channels(_text(message, "who"))

    def take_glb(self, message: Json) -> Response:
        """Return the take of a scene as binary glTF."""
        return _glb(self._shown(message).glb, {})

    def sound(self, message: Json) -> Response:
        """Return the sound track of a scene as WAV."""
        return Response(self._shown(message).sound, media_type="audio/wav")

    def camera(self, message: Json) -> Json:
        """Return the film's camera in every frame."""
        return {"camera": self._shown(message).camera}

    def still(self, message: Json) -> Response:
        """Return a frame of a scene by the film's renderer as PNG."""
        frame = message.get("frame")
        if not isinstance(frame, int):
            raise UsageError("the message holds no frame")
        return Response(self._shown(message).still(frame), media_type="image/png")

    def schema(self, message: Json) -> Json:
        """Return the schema of scenes or figures."""
        return _schema_of(message.get("kind") == "figure")

    def new_scene(self, message: Json) -> Json:
        """Write a starter scene into the project and return it."""
        path = write_starter(_text(message, "name"), self.project.folder)
        return _document(self.project.read(path.name))

    def render(self, message: Json) -> Json:
        """Append a film of a scene of the project to the render queue."""
        name = _text(message, "name")
        if self.project.read(name).is_shipped:
            raise UsageError("save the scene in this folder first")
        return self._queue.add(name, _text(message, "preset")).facts

    def renders(self, _: Json) -> Json:
        """Return the films of the render queue, the newest first."""
        return {"renders": self._queue.listed(), "presets": list(PRESETS)}

    def stop_render(self, message: Json) -> Json:
        """Stop a film of the render queue."""
        render = self._queue.find(message.get("number"))
        self._queue.stop(render)
        return render.facts

    def open_folder(self, message: Json) -> Json:
        """Show the folder of a film in the file manager."""
        folder = self._queue.open_folder(self._queue.find(message.get("number")))
        return {"folder": str(folder)}

    def rendered_frame(self, message: Json) -> Response:
        """Return the newest frame of a film as PNG, nothing before the first."""
        picture = self._queue.frame(self._queue.find(message.get("number")))
        return Response(picture, 200 if picture else 204, media_type="image/png")

    def _shown(self, message: Json) -> ScenePlay:
        play = self._page(message).play
        if play is None or message.get("play") != play[0]:
            raise Superseded
        return play[1]

    def _figure(self, message: Json) -> Figure:
        drawing = DrawnFigure.from_json(message.get("drawing"))
        text = _text(message, "text")
        return with_drawing(None if text == NEW_FIGURE else _figure_of(text), drawing)

    def _folder(self, message: Json) -> Path:
        name = message.get("name")
        return self.project.path_of(name).parent if name else self.project.folder


def _played(
    page: OpenPage, scene: Scene, still_wanted: Callable[[], None], first: FirstFrames
) -> ScenePlay:
    """Return the play of a scene, simulated only if the one that is shown has another take."""
    key = take_key(scene)
    if page.play is not None and page.play[1].take.header.key == key:
        return ScenePlay(scene, page.play[1].take)

    def see(simulation: Simulation) -> None:
        still_wanted()
        first.see(simulation)

    return ScenePlay(scene, Simulation(scene, key).run(see))


def _document(document: Document) -> Json:
    """Return a document as the page opens it."""
    facts: Json = {
        "name": document.name,
        "kind": document.kind,
        "text": document.text,
        "is_shipped": document.is_shipped,
        "kinds": list(get_args(PartKind)),
    }
    if document.kind == "figure":
        facts |= _drawing_of(document.text, document.name)
    return facts


def _drawing_of(text: str, name: str) -> Json:
    """Return the drawing of a figure's text, None where it is none, and what is wrong with it."""
    drawing, error = drawn_text(text, name)
    return {
        "drawing": drawing and drawing.as_json(),
        "error": str(error) if error else "",
        "problems": [problem_facts(problem) for problem in error.problems] if error else [],
    }


@lru_cache(maxsize=4)
def _figure_of(text: str) -> Figure:
    """Return the figure of a text, which stays the same while its drawing changes."""
    return figure_of_text(text)


@lru_cache
def _schema_of(is_figure: bool) -> Json:
    """Return a schema, which takes a third of a second to make and never changes."""
    return figure_schema() if is_figure else schema()


def _text(message: Json, key: str) -> str:
    value = message.get(key)
    if not isinstance(value, str):
        raise UsageError(f"the message holds no {key}")
    return value


def _glb(content: bytes, facts: Mapping[str, Any]) -> Response:
    headers = {"x-studio-facts": json.dumps(facts)}
    return Response(content, media_type="model/gltf-binary", headers=headers)


def application(studio: Studio, port: int) -> Guard:
    """Return the application of a studio on a port."""
    answers: dict[str, Callable[[Json], Json | Response]] = {
        "library": studio.library,
        "open": studio.open,
        "check": studio.check,
        "analyse": studio.analyse,
        "walk": studio.walk,
        "text": studio.text_of,
        "save": studio.save,
        "take": studio.take,
        "take.glb": studio.take_glb,
        "first-frames": studio.first_frames,
        "channels": studio.channels,
        "sound": studio.sound,
        "camera": studio.camera,
        "still": studio.still,
        "schema": studio.schema,
        "new-scene": studio.new_scene,
        "new-from": studio.new_from,
        "picture": studio.picture,
        "heard": studio.heard,
        "render": studio.render,
        "renders": studio.renders,
        "stop-render": studio.stop_render,
        "open-folder": studio.open_folder,
        "rendered-frame": studio.rendered_frame,
    }
    routes = [
        Route("/", _index(studio)),
        Route("/assets/{name}", _asset),
        *(Route(f"/api/{name}", _api(work), methods=["POST"]) for name, work in answers.items()),
    ]
    return Guard(Starlette(routes=routes), studio.token, port)


def _index(studio: Studio) -> Callable[[Request], Any]:
    async def answer(_: Request) -> Response:
        text = (PAGE / "index.html").read_text(encoding="utf-8")
        return Response(text.replace("{token}", studio.token), media_type="text/html")

    return answer


async def _asset(request: Request) -> Response:
    name = request.path_params["name"]
    if name not in ASSETS:
        return Response("there is no such file\n", 404, media_type="text/plain")
    return Response((PAGE / name).read_bytes(), media_type=ASSETS[name])


def _api(work: Callable[[Json], Json | Response]) -> Callable[[Request], Any]:
    """Return the endpoint of a piece of work: JSON in; JSON, bytes or one clear error out."""

    async def answer(request: Request) -> Response:
        try:
            message = json.loads(await request.body())
        except (ValueError, RecursionError):
            return _error(400, "the message is no JSON")
        if not isinstance(message, dict):
            return _error(400, "the message is no JSON object")
        try:
            result = await run_in_threadpool(work, message)
        except Superseded:
            return _error(409, "a newer request has come")
        except SceneError as error:
            problems = [problem_facts(problem) for problem in error.problems]
            return _error(422, str(error), problems)
        except PronkError as error:
            return _error(422, str(error))
        return result if isinstance(result, Response) else JSONResponse(result)

    return answer


def _error(status: int, text: str, problems: list[Json] | None = None) -> Response:
    return JSONResponse({"error": text, "problems": problems or []}, status)
