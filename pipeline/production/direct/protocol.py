"""Protocol: JSON-RPC 2.0, by pjrpc.

Of the libraries there are, pjrpc has no transport of its own to fit in, needs nothing else and
is kept well. What it does otherwise than the specification stands here: a batch is answered
request by request, so that one that is none harms no other, and only if there is anything to
answer.

Source: JSON-RPC 2.0 Specification, 2013.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from typing import Any, ClassVar

from pjrpc.server import Dispatcher, JsonRpcError, MethodRegistry
from pjrpc.server.exceptions import (
    InvalidParamsError,
    InvalidRequestError,
    ParseError,
    TypedError,
)
from pjrpc.server.validators.base import (
    BaseValidator,
    BaseValidatorFactory,
    MethodType,
    ValidationError,
)

from pipeline.errors import PronkError, SceneError
from pipeline.production.direct.framing import MOST_BYTES, TooLong

DEEPEST = 48
"""Levels of lists and mappings in each other."""

MOST_IN_BATCH = 1000
"""Requests of one message."""

Method = Callable[[Mapping[str, Any]], object]
"""Returns what a request asks for, given its parameters."""


class OutOfOrder(TypedError):
    """The request comes too late."""

    CODE: ClassVar[int] = -32001
    MESSAGE: ClassVar[str] = "Out of order"


class Failed(TypedError):
    """The simulation failed, or the take cannot be written."""

    CODE: ClassVar[int] = -32002
    MESSAGE: ClassVar[str] = "Failed"


class Protocol:
    """Answers to messages.

    Args:
        methods: by the names that requests call them.
    """

    def __init__(self, methods: Mapping[str, Method]) -> None:
        registry = MethodRegistry(_Named())
        for name, method in methods.items():
            registry.add_method(_telling(method), name)
        self._dispatcher: Dispatcher[None] = Dispatcher()
        self._dispatcher.add_methods(registry)

    def answer(self, message: bytes | TooLong) -> str | None:
        """Return the answer to a message, None if it wants none."""
        if isinstance(message, TooLong):
            return _error(InvalidRequestError(data=f"a message has at most {MOST_BYTES} bytes"))
        try:
            words = _decoded(message)
        except ValueError as error:
            return _error(ParseError(data=str(error)))
        if not isinstance(words, list):
            return self._one(words)
        if not words or len(words) > MOST_IN_BATCH:
            data = f"a batch has 1 to {MOST_IN_BATCH} requests"
            return _error(InvalidRequestError(data=data))
        answers = [answer for one in words if (answer := self._one(one)) is not None]
        return f"[{', '.join(answers)}]" if answers else None

    def _one(self, words: object) -> str | None:
        if not isinstance(words, dict):
            return _error(InvalidRequestError(data="a request should be a mapping"))
        if "id" in words and (words["id"] is None or isinstance(words["id"], bool)):
            return _error(InvalidRequestError(data="id should be a whole number or text"))
        found = self._dispatcher.dispatch(json.dumps(words), None)
        return None if found is None else found[0]


def notification(method: str, params: Mapping[str, object]) -> str:
    """Return the text of a message that wants no answer."""
    return json.dumps({"jsonrpc": "2.0", "method": method, "params": params})


class _Named(BaseValidatorFactory):
    """Gives methods their parameters as one mapping, which they check themselves."""

    def build(self, method: MethodType) -> BaseValidator:
        return _Mapping(method)


class _Mapping(BaseValidator):
    def validate_params(self, params: Any) -> dict[str, Any]:
        if params and not isinstance(params, dict):
            raise ValidationError("params should be a mapping of names to values")
        return {"params": params or {}}


def _telling(method: Method) -> Method:
    """Let a method tell what went wrong as the protocol wants it."""

    def called(params: Mapping[str, Any]) -> object:
        try:
            return method(params)
        except SceneError as error:
            problems = [{"path": one.path, "message": one.message} for one in error.problems]
            text = "; ".join(": ".join(filter(None, one.values())) for one in problems)
            raise InvalidParamsError(text, data=problems) from None
        except PronkError as error:
            raise Failed(str(error)) from None

    return called


def _error(error: JsonRpcError) -> str:
    """Return the answer to what is no request, of which not even the id is known."""
    return json.dumps({"jsonrpc": "2.0", "id": None, "error": error.to_json()})


def _decoded(message: bytes) -> object:
    """Return what a message holds.

    Raises:
        ValueError: it is no JSON.
    """
    try:
        words = json.loads(message.decode("utf-8"), parse_constant=_refuse_constant)
    except RecursionError:
        words = None
        deep = True
    else:
        deep = _is_deep(words)
    if deep:
        raise ValueError(f"lists and mappings go deeper than {DEEPEST} levels")
    return words


def _refuse_constant(name: str) -> Any:
    raise ValueError(f"{name} is no number of JSON")


def _is_deep(words: object) -> bool:
    level: list[object] = [words]
    for _ in range(DEEPEST):
        level = [
            below
            for one in level
            if isinstance(one, dict | list)
            for below in (one.values() if isinstance(one, dict) else one)
        ]
        if not level:
            return False
    return True
