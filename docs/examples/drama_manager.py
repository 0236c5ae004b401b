"""A small drama manager: brings a cast together, two at a time, and counts how they meet.

    python docs/examples/drama_manager.py SCENE [--out FOLDER] [--pronk COMMAND]
    python docs/examples/drama_manager.py HOST:PORT --token-file FILE

It starts `pronk direct SCENE`, or connects to one that waits at a port, and queries the cast. Until
the end of the scene it sends the performer that waited longest to the one that was visited least.
On arrival the visited performer looks at the visitor, and the next pair follows. Performers that
can hug do so. Nothing of pronk is imported: any program that speaks JSON-RPC 2.0 can do the same.
"""

import argparse
import itertools
import json
import shlex
import socket
import subprocess
import sys

VISIT_TIMEOUT = 8.0
"""Longest duration of a visit [s]."""


class Stage:
    """Connection to a directed scene.

    Attributes:
        events: notifications so far.
    """

    def __init__(self, reader, writer, leave):
        self.events = []
        self.leave = leave
        self._numbers = itertools.count(1)
        self._reader, self._writer = reader, writer

    @staticmethod
    def started(command):
        """Start pronk and connect to its standard input and output."""
        process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)

        def leave():
            process.stdin.close()
            return process.wait()

        return Stage(process.stdout, process.stdin, leave)

    @staticmethod
    def connected(address, token):
        """Connect to a port, where the first line is `hello` with the token."""
        host, _, port = address.rpartition(":")
        connection = socket.create_connection((host, int(port)))
        stream = connection.makefile("rwb")

        def leave():
            stream.close()
            connection.close()
            return 0

        stage = Stage(stream, stream, leave)
        try:
            stage.ask("hello", token=token)
        except ValueError as error:
            raise SystemExit(f"{address}: {error}") from None
        return stage

    def ask(self, method, **params):
        """Send a request and return its result, keeping notifications.

        Raises:
            ValueError: the request was refused.
        """
        number = next(self._numbers)
        request = {"jsonrpc": "2.0", "id": number, "method": method, "params": params}
        self._writer.write(json.dumps(request).encode() + b"\n")
        self._writer.flush()
        for line in self._reader:
            message = json.loads(line)
            if "method" in message:
                self.events.append(message["params"])
            elif "error" in message:
                raise ValueError(message["error"]["message"])
            else:
                return message["result"]
        raise SystemExit(self.leave() or 1)


class Manager:
    """Chooses the visits.

    Attributes:
        meetings: visitor, visited performer, and time of each meeting.
    """

    def __init__(self, stage):
        self.stage = stage
        found = stage.ask("query", what=["performers", "places"])
        self.cast = [name for name in found["performers"] if self._can_walk(name)]
        self.meetings = []
        self._visited = dict.fromkeys(self.cast, 0)
        self._last = dict.fromkeys(self.cast, -1.0)
        stage.ask("subscribe", events=["arrived", "touch", "pain", "hug"])

    def direct(self):
        """Direct until the end of the scene."""
        time, finished = 0.0, False
        while len(self.cast) > 1 and not finished:
            visitor = min(self.cast, key=lambda name: (self._last[name], name))
            others = [name for name in self.cast if name != visitor]
            visited = min(others, key=lambda name: (self._visited[name], self._last[name], name))
            hugs = self._send(visitor, visited)
            found = self.stage.ask(
                "step", event=["arrived"], who=[visitor], until=time + VISIT_TIMEOUT
            )
            time, finished = found["time"], found["finished"]
            self._last[visitor] = time
            self._visited[visited] += 1
            if found["happened"] and not finished:
                self.meetings.append((visitor, visited, time))
                self._try(visited, {"look_at": visitor})
                found = self.stage.ask("step", until=time + 1.2)
                time, finished = found["time"], found["finished"]
            if hugs:
                self._try(visitor, "let_go")

    def _can_walk(self, name):
        """Return whether a performer accepts orders."""
        return self._try(name, "stop")

    def _send(self, visitor, visited):
        """Send a visitor; return whether it hugs, which not every performer can."""
        if self._try(visitor, {"hug": visited}):
            return True
        x, _, z = self.stage.ask("query", what=["places"], who=[visited])["places"][visited]
        near = self.stage.ask("query", what=["places"], who=[visitor])["places"][visitor]
        # Stop at an arm's length.
        far = max(((x - near[0]) ** 2 + (z - near[2]) ** 2) ** 0.5, 1e-9)
        part = max(1.0 - 0.8 / far, 0.0)
        place = [near[0] + part * (x - near[0]), near[2] + part * (z - near[2])]
        self._try(visitor, {"go_to": place})
        return False

    def _try(self, who, do):
        """Send a command; return whether the performer can carry it out."""
        try:
            self.stage.ask("command", who=who, do=do)
        except ValueError:
            return False
        return True


def main():
    """Direct a scene and report the meetings."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scene", help="scene, or address of a port where one waits")
    parser.add_argument("--token-file", help="file that holds the token of the port")
    parser.add_argument("--out", default="out")
    parser.add_argument("--pronk", default="pronk", help="command of pronk")
    given = parser.parse_args()
    if given.token_file:
        with open(given.token_file) as file:
            stage = Stage.connected(given.scene, file.read().strip())
    else:
        command = [*shlex.split(given.pronk), "direct", given.scene, "--out", given.out, "-q"]
        stage = Stage.started(command)
    manager = Manager(stage)
    manager.direct()
    end = stage.ask("end")
    for visitor, visited, time in manager.meetings:
        print(f"{time:6.2f} s  {visitor} has come to {visited}")
    counts = {
        kind: sum(event["kind"] == kind for event in stage.events) for kind in ("touch", "pain")
    }
    print(f"{counts['touch']} touches, {counts['pain']} of them painful" if counts["touch"] else "")
    print(f"the scene: {end['scene']}\nits take: {end['take']}")
    return stage.leave()


if __name__ == "__main__":
    sys.exit(main())
