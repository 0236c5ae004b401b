"""House materials: plasters, stone, tiles, paints and glass of houses."""

from __future__ import annotations

from collections.abc import Mapping

from render.config import Material


def _plaster(color: str, second: str) -> Material:
    values = {"color": color, "color2": second, "roughness": 0.95, "texture": "plaster"}
    return Material.model_validate({**values, "texture_scale": 3.0, "bump": 0.4})


def _dull(color: str, roughness: float = 0.8, texture: str = "mottle") -> Material:
    values = {"color": color, "roughness": roughness, "texture": texture, "bump": 0.3}
    return Material.model_validate({**values, "texture_scale": 0.8})


def _behind_glass(color: str) -> Material:
    """Return cloth that hangs behind a pane: dim, under the pane's reflections."""
    return Material.model_validate({"color": color, "roughness": 0.9, "clearcoat": 1.0})


def _glowing(color: str, glow: float) -> Material:
    return Material.model_validate({"color": color, "roughness": 0.3, "glow": glow})


# Both faces of the glass reflect.
PANE = Material.model_validate(
    {"color": "#1a2428", "roughness": 0.04, "clearcoat": 1.0, "ior": 2.2}
)
LANTERN_GLASS = Material.model_validate({"color": "#cdbf9a", "roughness": 0.3})

DRESSINGS = {"curtain": "#998d78", "blind": "#8c7b5c", "net": "#8a8c87"}
"""Colours of what hangs behind panes."""

MATERIALS_OF_HOUSES: Mapping[str, Material] = {
    "ochre": _plaster("#b18d61", "#a9875d"),
    "rose": _plaster("#ad8072", "#a77a6c"),
    "cream": _plaster("#d6c8ac", "#d0c2a4"),
    "grey": _plaster("#a5a7a6", "#9fa1a0"),
    "sage": _plaster("#8f9786", "#899180"),
    "straw": _plaster("#cdba90", "#c7b48a"),
    "white": _plaster("#ded9cc", "#d8d3c5"),
    "brick": _plaster("#856155", "#7f5b50"),
    "hewn stone": _plaster("#b3a78f", "#aa9e87"),
    "tile red": _dull("#895847"),
    "tile brown": _dull("#7a4e44"),
    "tile dark": _dull("#65453c"),
    "shutter green": _dull("#435649", 0.55, "wood"),
    "shutter blue": _dull("#556976", 0.55, "wood"),
    "shutter brown": _dull("#624b3c", 0.55, "wood"),
    "shutter grey": _dull("#7d7e79", 0.55, "wood"),
    "awning red": _dull("#91473d", 0.9, "weave"),
    "awning green": _dull("#43654e", 0.9, "weave"),
    "awning blue": _dull("#46607c", 0.9, "weave"),
    "awning white": _dull("#d8d3c6", 0.9, "weave"),
    "zinc": _dull("#8b908f", 0.45),
    "window frame": _dull("#cfc8b8", 0.7),
    "pane": PANE,
    # By day one does not see that somebody is at home.
    "lit pane": PANE,
    "dim pane": PANE,
    **{
        f"{light}{name}": _behind_glass(color)
        for light in ("", "lit ", "dim ")
        for name, color in DRESSINGS.items()
    },
    "lantern glass": LANTERN_GLASS,
    "water": Material.model_validate({"color": "#24403c", "roughness": 0.06}),
}
"""Materials of houses, by the names that follow `edging`."""

AFTER_DARK: Mapping[str, Material] = {
    "lit pane": _glowing("#ffa955", 1.2),
    "dim pane": _glowing("#ff8f3c", 0.5),
    **{
        f"{light}{name}": _glowing(color, share * glow)
        for light, glow in (("lit ", 1.0), ("dim ", 0.42))
        for name, color, share in (
            ("curtain", "#d9722e", 0.3),
            ("blind", "#e08a44", 0.34),
            ("net", "#e8a468", 0.5),
        )
    },
    "lantern glass": _glowing("#ffc27a", 1.5),
}
"""Those that glow when the sun is down: panes, what hangs before the light behind them, and the
lanterns of the street."""
