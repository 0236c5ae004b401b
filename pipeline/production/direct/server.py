"""Serving: messages in, answers and news out, and a take at the end, whoever is still there."""

from __future__ import annotations

import contextlib

from pipeline.production.direct.framing import Gone, Wire
from pipeline.production.direct.notifications import Item
from pipeline.production.direct.protocol import Protocol, notification
from pipeline.production.direct.recording import Kept, Place
from pipeline.production.direct.session import Session
from pipeline.production.direct.transport import Door
from pipeline.production.run.interrupts import answered
from pipeline.simulation.casting import makes_machine_code
from pipeline.spec import Scene

HAPPENED = "happened"
"""What a notification is called."""


def direct(scene: Scene, place: Place, door: Door) -> Kept:
    """Let another program direct a scene.

    When it goes away before the end of the scene, or Ctrl-C is pressed, the scene goes on to
    its end without it.

    Raises:
        PronkError: if the scene cannot begin, fails, or cannot be written.
    """
    place.check()
    if makes_machine_code(scene):
        place.reporter.note("making machine code; that takes a minute, once")
    session = Session(scene, place)
    try:
        with door(place.reporter.note) as wire:
            serve(session, wire)
        # Who sends messages may have been stopped a moment before us by the same Ctrl-C.
        return session.kept or session.finish()
    except KeyboardInterrupt:
        answered()
        place.reporter.note("stopped; the scene goes to its end, unless it is stopped again")
    return session.kept or session.finish()


def serve(session: Session, wire: Wire) -> None:
    """Answer messages until nobody is there to send any."""

    def tell(item: Item) -> None:
        # That nobody listens is noticed when the answer is sent.
        with contextlib.suppress(Gone):
            wire.send(notification(HAPPENED, item))

    session.tell = tell
    protocol = Protocol(session.methods)
    with contextlib.suppress(Gone):
        for message in wire.messages():
            answer = protocol.answer(message)
            if answer is not None:
                wire.send(answer)
