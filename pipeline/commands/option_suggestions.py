"""Option suggestions: what to write instead of an option that a command does not have."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

from typer.core import TyperCommand

UNKNOWN_OPTION = "NoSuchOption"
"""Class of the error about an unknown option, in the command-line library that Typer builds on."""


class SuggestingCommand(TyperCommand):
    """A command that says of an unknown option which one was meant, or which command has it."""

    def parse_args(self, ctx: Any, args: list[str]) -> list[str]:
        """Parse the arguments; the error about an unknown option says what would be right."""
        try:
            return super().parse_args(ctx, args)
        except Exception as error:
            # Typer carries a copy of that library with it or takes the installed one.
            if type(error).__name__ == UNKNOWN_OPTION:
                name = getattr(error, "option_name", "")
                vars(error)["message"] = _unknown_option_text(name, self, ctx)
                vars(error)["possibilities"] = None
            raise


def _unknown_option_text(name: str, command: Any, context: Any) -> str:
    """Return what is wrong with an option that a command does not have, and what would be right.

    Args:
        name: such as `--strikt`.
        command: that was called.
        context: of the call.
    """
    from pipeline.spec.suggestions import close_names, joined_choices

    own = _options(command)
    has = f"{context.info_name} has {_listed(own) if own else 'none'}"
    others = [
        path for path, other in _commands(context.find_root().command) if name in _options(other)
    ]
    if others:
        return f"'{name}' is an option of {_listed(others)}, not of {context.info_name}; {has}"
    # The dashes are alike in all.
    close = close_names(name.lstrip("-"), [option.lstrip("-") for option in own])
    if close:
        meant = joined_choices(f"--{option}" for option in close)
        return f"no option is called '{name}', did you mean {meant}?"
    return f"no option is called '{name}'; {has}"


def _options(command: Any) -> list[str]:
    """Return the long options of a command."""
    names = (name for param in command.params for name in (*param.opts, *param.secondary_opts))
    return [name for name in names if name.startswith("--")]


def _commands(command: Any, above: str = "") -> Iterator[tuple[str, Any]]:
    """Yield all commands with their names, those of groups after the group's."""
    for name, below in getattr(command, "commands", {}).items():
        path = f"{above} {name}".strip()
        if getattr(below, "commands", None):
            yield from _commands(below, path)
        else:
            yield path, below


def _listed(names: Sequence[str]) -> str:
    *others, last = names
    return f"{', '.join(others)} and {last}" if others else last
