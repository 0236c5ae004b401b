"""Protocol: JSON-RPC 2.0, by pjrpc.

pjrpc brings no transport, needs no other library and is maintained. One thing is done here
because it deviates from the specification: a batch is answered request by request, so that an
invalid one affects no other, and only if there is anything to answer.

Source: JSON-RPC 2013.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from typing import Any, ClassVar

from pjrpc.server import Dispatcher, JsonRpcError, MethodRegistry
from pjrpc.server.exceptions import InvalidParamsError, InvalidRequestError, ParseError, TypedError
from pjrpc.server.validators.base import (
    BaseValidator,
    BaseValidatorFactory,
    MethodType,
    ValidationError,
)

from pipeline.errors import PronkError, SceneError
from pipeline.production.direct.messages import (
    MAX_MESSAGE_BYTES,
    OversizedMessage,
    decoded,
    refusal,
)

MAX_BATCH = 1000
"""Most requests of one message."""

MAX_ANSWER_BYTES = 2**24
"""Size of a batch's answers after which its further requests are refused [bytes]."""

Method = Callable[[Mapping[str, Any]], object]
"""Returns the result of a request with these parameters."""


class OutOfOrder(TypedError):
    """The request comes too late."""

    CODE: ClassVar[int] = -32001
    MESSAGE: ClassVar[str] = "Out of order"


class SimulationFailed(TypedError):
    """The simulation failed, or the take cannot be written."""

    CODE: ClassVar[int] = -32002
    MESSAGE: ClassVar[str] = "Failed"


class Protocol:
    """The answers to messages.

    Args:
        methods: by name.
    """

    def __init__(self, methods: Mapping[str, Method]) -> None:
        registry = MethodRegistry(_NamedParams())
        for name, method in methods.items():
            registry.add_method(_with_rpc_errors(method), name)
        self._dispatcher: Dispatcher[None] = Dispatcher()
        self._dispatcher.add_methods(registry)

    def answer(self, message: bytes | OversizedMessage) -> str | None:
        """Return the answer to a message, None for notifications."""
        if isinstance(message, OversizedMessage):
            return _error(
                InvalidRequestError(data=f"a message has at most {MAX_MESSAGE_BYTES} bytes")
            )
        try:
            content = decoded(message)
        except ValueError as error:
            return _error(ParseError(data=str(error)))
        if not isinstance(content, list):
            return self._answer_one(content)
        if not content or len(content) > MAX_BATCH:
            data = f"a batch has 1 to {MAX_BATCH} requests"
            return _error(InvalidRequestError(data=data))
        return self._answer_batch(content)

    def _answer_batch(self, requests: list[object]) -> str | None:
        answers, size = list[str](), 0
        for request in requests:
            if size > MAX_ANSWER_BYTES:
                answer: str | None = _too_many_answers(request)
            else:
                answer = self._answer_one(request)
            if answer is not None:
                answers.append(answer)
                size += len(answer)
        return f"[{', '.join(answers)}]" if answers else None

    def _answer_one(self, request: object) -> str | None:
        if not isinstance(request, dict):
            return _error(InvalidRequestError(data="a request should be a mapping"))
        if "id" in request and (request["id"] is None or isinstance(request["id"], bool)):
            return _error(InvalidRequestError(data="id should be a whole number or text"))
        answer = self._dispatcher.dispatch(json.dumps(request), None)
        return None if answer is None else answer[0]


class _NamedParams(BaseValidatorFactory):
    """Passes parameters as one mapping, which methods validate themselves."""

    def build(self, method: MethodType) -> BaseValidator:
        return _Mapping(method)


class _Mapping(BaseValidator):
    def validate_params(self, params: Any) -> dict[str, Any]:
        if params and not isinstance(params, dict):
            raise ValidationError("params should be a mapping of names to values")
        return {"params": params or {}}


def _with_rpc_errors(method: Method) -> Method:
    """Return a method that raises the errors of the protocol."""

    def called(params: Mapping[str, Any]) -> object:
        try:
            return method(params)
        except SceneError as error:
            problems = [{"path": p.path, "message": p.message} for p in error.problems]
            text = "; ".join(": ".join(filter(None, p.values())) for p in problems)
            raise InvalidParamsError(text, data=problems) from None
        except PronkError as error:
            raise SimulationFailed(str(error)) from None

    return called


def _too_many_answers(request: object) -> str:
    """Return the answer to a request of a batch that is not carried out."""
    data = f"the batch was answered with over {MAX_ANSWER_BYTES} bytes before; send it in parts"
    number = request.get("id") if isinstance(request, dict) else None
    known = number if type(number) in (int, str) else None
    return refusal(InvalidRequestError(data=data).to_json(), known)


def _error(error: JsonRpcError) -> str:
    """Return the answer to an invalid request, whose id is unknown."""
    return refusal(error.to_json())
