"""Usage errors: those of the command-line library, with control characters escaped."""

from __future__ import annotations

from typing import Any

from typer.core import TyperGroup

from pipeline.terminal_text import escaped_line


class EscapingGroup(TyperGroup):
    """A group of commands whose errors quote arguments without their control characters."""

    def make_context(self, *args: Any, **members: Any) -> Any:
        """Parse the arguments of the group; errors are told escaped."""
        try:
            return super().make_context(*args, **members)
        except Exception as error:
            _escape(error)
            raise

    def invoke(self, ctx: Any) -> Any:
        """Run the command that the arguments name; errors are told escaped."""
        try:
            return super().invoke(ctx)
        except Exception as error:
            _escape(error)
            raise


def _escape(error: Exception) -> None:
    """Escape the message of an error, if it is one of the command-line library."""
    # Typer carries a copy of that library with it or takes the installed one.
    message = getattr(error, "format_message", None)
    if message is not None:
        text = escaped_line(message())
        vars(error)["format_message"] = lambda: text
