"""`pronk farm`: films made by many machines. No logic; imports are made when commands run."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, ClassVar

import typer

from pipeline.commands.option_suggestions import SuggestingCommand
from pipeline.commands.options import (
    FrameOptions,
    FramesOption,
    NoSoundOption,
    PresetOption,
    Reporting,
    SceneName,
    SceneNames,
    StrictOption,
    say,
    with_options,
)

if TYPE_CHECKING:
    from pipeline.production.run.order import Order
    from pipeline.production.run.progress import Reporter

StoreAddress = Annotated[
    str,
    typer.Option(
        "--store",
        metavar="URL",
        help="Where takes and frames are: a shared folder, or s3://bucket/folder, sftp://...",
    ),
]
TakeKey = Annotated[
    str | None,
    typer.Option(
        "--take", metavar="KEY", help="Take that 'farm simulate' printed; default: this machine's."
    ),
]
Mixed = Annotated[
    bool,
    typer.Option("--mixed", help="Let several classes of processors or versions render one film."),
]


@dataclass(kw_only=True)
class FarmOptions(FrameOptions):
    """Options of the commands of a farm."""

    stopped: ClassVar[str] = "what is in the store stays; the same command goes on"


@dataclass(kw_only=True)
class StatusOptions(Reporting):
    """Options of the command that looks at a store."""

    stopped: ClassVar[str] = "nothing was changed"

    are_scenes: ClassVar[bool] = False


farm = typer.Typer(no_args_is_help=True, help="Films made by many machines through one store.")


@farm.command(cls=SuggestingCommand)
@with_options
def simulate(
    scenes: SceneNames,
    store: StoreAddress,
    options: FarmOptions,
    preset: PresetOption = None,
    strict: StrictOption = False,
) -> None:
    """Simulate scenes into a store; print the key of each take."""
    from pipeline.farm.shards import prepare_film
    from pipeline.farm.store import Store

    place = Store(store)

    def make(name: str, reporter: Reporter) -> None:
        film = prepare_film(options.frame_order(name, preset, strict=strict), place, reporter)
        reporter.result(film.take, take=film.take, film=film.key, frames=film.frames)

    options.run_each(scenes, make)


@farm.command(cls=SuggestingCommand)
@with_options
def render(
    scenes: SceneNames,
    store: StoreAddress,
    options: FarmOptions,
    preset: PresetOption = None,
    on: Annotated[
        str,
        typer.Option(
            metavar="WHERE",
            help="local: processes of this machine; auto: a Ray cluster on this machine; or the "
            "address of a Ray cluster.",
        ),
    ] = "local",
    jobs: Annotated[
        int | None,
        typer.Option(min=1, max=256, help="Workers on this machine; default: by its cores."),
    ] = None,
    cores: Annotated[
        int | None,
        typer.Option(
            min=1, max=4096, help="Cores of each worker; default: by the size of pictures, 2 or 4."
        ),
    ] = None,
    frames: FramesOption = None,
    no_sound: NoSoundOption = False,
    strict: StrictOption = False,
    mixed: Mixed = False,
) -> None:
    """Render films on the workers of a farm: simulate, render the frames, assemble.

    Scenes are made side by side; where one fails, the others are made all the same. A run that was
    stopped goes on where it was, from whichever machine.
    """
    from pipeline.farm.farm_run import FarmSettings, render_films
    from pipeline.production.run.frame_ranges import read_frames
    from pipeline.production.run.order import refuse_clashes

    if frames is not None:
        read_frames(frames)
    refuse_clashes(scenes, options.out)
    options.assignments()

    def order_of(name: str) -> Order:
        settings = {"frames": frames, "sound": not no_sound, "strict": strict}
        return options.frame_order(name, preset, **settings)

    settings = FarmSettings(store, on, jobs, cores, options.backend.value, strict, mixed)
    code = render_films(scenes, order_of, settings, options.reporter(), say)
    if code:
        raise typer.Exit(code)


@farm.command("frames", cls=SuggestingCommand)
@with_options
def render_frames(
    scene: SceneName,
    store: StoreAddress,
    options: FarmOptions,
    preset: PresetOption = None,
    take: TakeKey = None,
    frames: FramesOption = None,
    shard: Annotated[
        str | None, typer.Option(metavar="N/M", help="One of M parts of the frames, such as 3/8.")
    ] = None,
    threads: Annotated[
        int | None,
        typer.Option(min=1, max=4096, help="Threads of the renderer; default: all processors."),
    ] = None,
    mixed: Mixed = False,
) -> None:
    """Render frames into a store: the work of one machine of a farm.

    Locks nothing, and writes no score and no film. Frames that the store has are left alone.
    """
    from pipeline.farm.shards import render_shard
    from pipeline.farm.store import Store

    place, reporter = Store(store), options.reporter()
    order = options.frame_order(scene, preset, frames=frames)
    done = render_shard(order, place, reporter, take, shard, threads, mixed)
    reporter.result(done.text, **done.facts)


@farm.command(cls=SuggestingCommand)
@with_options
def encode(
    scene: SceneName,
    store: StoreAddress,
    options: FarmOptions,
    preset: PresetOption = None,
    take: TakeKey = None,
    frames: FramesOption = None,
    shard: Annotated[
        str | None, typer.Option(metavar="N/M", help="One of M parts of the segments, such as 3/8.")
    ] = None,
    mixed: Mixed = False,
) -> None:
    """Encode segments of ten seconds into a store, of frames that are there.

    'farm assemble' joins them and encodes those that are missing. A film of one segment is left to
    it. Segments that the store has are left alone.
    """
    from pipeline.farm.shards import encode_shard
    from pipeline.farm.store import Store

    place, reporter = Store(store), options.reporter()
    order = options.frame_order(scene, preset, frames=frames)
    done = encode_shard(order, place, reporter, take, shard, mixed)
    reporter.result(done.text, **done.facts)


@farm.command(cls=SuggestingCommand)
@with_options
def assemble(
    scenes: SceneNames,
    store: StoreAddress,
    options: FarmOptions,
    preset: PresetOption = None,
    take: TakeKey = None,
    frames: FramesOption = None,
    no_sound: NoSoundOption = False,
    strict: StrictOption = False,
    mixed: Mixed = False,
) -> None:
    """Make films of frames that are in a store, with score and sound.

    Ends with 4 and names the frames if some are missing.
    """
    from pipeline.farm.assembly import assemble as assembled
    from pipeline.farm.film import film_of
    from pipeline.farm.store import Store
    from pipeline.production.run.frame_ranges import read_frames

    if frames is not None:
        read_frames(frames)
    place = Store(store)

    def make(name: str, reporter: Reporter) -> None:
        settings = {"frames": frames, "sound": not no_sound, "strict": strict}
        order = options.frame_order(name, preset, **settings)
        film, _ = film_of(order.scene, order.name, take)
        reporter.result(f"{assembled(order, place, film, reporter, mixed).folder}")

    options.run_each(scenes, make)


@farm.command(cls=SuggestingCommand)
@with_options
def status(
    store: StoreAddress,
    options: StatusOptions,
    html: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write a page with thumbnails as well.")
    ] = None,
    watch: Annotated[
        float | None,
        typer.Option(min=1.0, metavar="SECONDS", help="Look again, until all frames are there."),
    ] = None,
) -> None:
    """Print the films of a store: frames, rate, time left, failures."""
    from pipeline.farm.status_watch import report_status
    from pipeline.farm.store import Store

    report_status(Store(store), options.reporter(), html, watch)


@farm.command(cls=SuggestingCommand)
@with_options
def export(
    scenes: SceneNames,
    options: FarmOptions,
    openjd: Annotated[
        Path, typer.Option(metavar="FILE", help="File of the Open Job Description template.")
    ],
    preset: PresetOption = None,
    frames: FramesOption = None,
    no_sound: NoSoundOption = False,
) -> None:
    """Write a job template for farms with a manager of their own, such as Deadline Cloud."""
    from pipeline.farm.job_template import job_scene, write_template
    from pipeline.production.run.order import refuse_clashes
    from pipeline.spec import find_scene

    refuse_clashes(scenes, options.out)
    changes = ["--preset", preset.value] if preset else []
    changes += [part for change in options.assignments() for part in ("--set", change)]
    found = []
    for name in scenes:
        order = options.frame_order(name, preset, frames=frames, sound=not no_sound)
        found.append(job_scene(order, find_scene(name), openjd, changes))
    write_template(found, openjd)
    options.reporter().result(f"{openjd}")
