"""Server: answers messages, sends notifications, and records the scene at its end."""

from __future__ import annotations

import contextlib

from pipeline.production.direct.message_stream import Disconnected, MessageStream
from pipeline.production.direct.messages import notification
from pipeline.production.direct.notification_queue import Notification
from pipeline.production.direct.protocol import Protocol
from pipeline.production.direct.scene_recorder import RecordedScene, SceneRecorder
from pipeline.production.direct.session import Session
from pipeline.production.direct.transport import Transport
from pipeline.production.run.compile_progress import compile_progress
from pipeline.production.run.interrupts import answered
from pipeline.spec import Scene

NOTIFICATION_METHOD = "happened"
"""Method of notifications."""


def direct(scene: Scene, recorder: SceneRecorder, transport: Transport) -> RecordedScene:
    """Serve another program that directs a scene.

    When it disconnects before the end of the scene, or Ctrl-C is pressed, the scene goes on to its
    end without it.

    Raises:
        PronkError: the scene cannot start, fails, or cannot be written.
    """
    recorder.check()
    with compile_progress(recorder.reporter):
        session = Session(scene, recorder)
        try:
            with transport(recorder.reporter.note) as stream:
                serve(session, stream)
            if session.goes_on:
                end = stream.end or "has disconnected"
                recorder.reporter.note(f"the other program {end}; the scene goes to its end")
            # The same Ctrl-C can have stopped the other program a moment earlier.
            return session.recorded or session.finish()
        except KeyboardInterrupt:
            answered()
            recorder.reporter.note("stopped; the scene goes to its end, unless it is stopped again")
        return session.recorded or session.finish()


def serve(session: Session, stream: MessageStream) -> None:
    """Answer messages until the other program disconnects."""

    def notify(event: Notification) -> None:
        # A lost connection is noticed when the answer is sent.
        with contextlib.suppress(Disconnected):
            stream.send(notification(NOTIFICATION_METHOD, event))

    session.notify = notify
    protocol = Protocol(session.methods)
    with contextlib.suppress(Disconnected):
        for message in stream.messages():
            answer = protocol.answer(message)
            if answer is not None:
                stream.send(answer)
