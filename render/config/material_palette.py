"""The palette: all named materials, one to a row.

A row holds the base colour, the second colour that the texture mixes in (or None), the roughness,
the texture (name, length after which it repeats [m], relief), and what differs from the defaults
of `Material`.
"""

from __future__ import annotations

from typing import Any

Row = dict[str, Any]


def _row(
    color: str,
    color2: str | None,
    roughness: float,
    texture: tuple[str, float] | tuple[str, float, float] | None,
    **others: float | str,
) -> Row:
    keys = ("texture", "texture_scale", "bump")
    pattern = dict(zip(keys, texture or (), strict=False))
    second = {} if color2 is None else {"color2": color2}
    return {"color": color, **second, "roughness": roughness, **pattern, **others}


def _cloth(color: str) -> Row:
    return _row(color, None, 0.82, ("weave", 0.025, 0.22), sheen=0.3)


# fmt: off
CREATURES: dict[str, Row] = {
    "green chitin":   _row("#3f6420", "#6e5a22", 0.36, ("shell", 0.3, 1.7),
                           metallic=0.6, clearcoat=0.5),
    "brown chitin":   _row("#5a3217", "#7a4a22", 0.6, ("carapace", 0.4, 1.7),
                           metallic=0.05, clearcoat=0.15),
    "black chitin":   _row("#1b1a1d", "#33271f", 0.56, ("carapace", 0.4, 1.7),
                           metallic=0.1, clearcoat=0.2),
    "red chitin":     _row("#7c2d1d", "#4a1c12", 0.58, ("carapace", 0.4, 1.7),
                           clearcoat=0.18),
    "blue chitin":    _row("#1f4a85", "#1b6a86", 0.5, ("shell", 0.3, 1.7),
                           metallic=0.3, clearcoat=0.2),
    "amber chitin":   _row("#96703a", "#5c3c1c", 0.58, ("carapace", 0.4, 1.7),
                           clearcoat=0.18),
    "violet chitin":  _row("#4b2a6b", "#7a2a5e", 0.5, ("shell", 0.3, 1.7),
                           metallic=0.3, clearcoat=0.2),
    "ivory chitin":   _row("#cdbf98", "#a08f62", 0.5,  ("carapace", 0.4, 1.2), clearcoat=0.3),
    "bone":           _row("#ddd0b4", "#c9b68e", 0.45, ("mottle", 0.3), clearcoat=0.2),
    "ivory":          _row("#e6dcc3", "#d8c8a0", 0.3,  ("wood", 0.4), clearcoat=0.4),
    "skin":           _row("#c98f73", "#b87a62", 0.5,  ("pores", 0.12, 0.7),
                           clearcoat=0.1, sheen=0.3, subsurface=1.0),
    "green skin":     _row("#5a7a2c", "#46642a", 0.35, ("pores", 0.12, 0.8), clearcoat=0.5),
    "wet skin":       _row("#567527", "#3f5c22", 0.4,  ("pores", 0.45, 3.5), clearcoat=0.55),
    "green scales":   _row("#5c7a30", "#3f5a26", 0.45, ("scales", 0.5, 1.0), clearcoat=0.25),
    "brown scales":   _row("#7a6440", "#5a4529", 0.5,  ("scales", 0.5, 1.0), clearcoat=0.2),
    "grey hide":      _row("#6b655d", "#6d6256", 0.9,  ("wrinkles", 0.9, 1.6), sheen=0.2),
    "dark skin":      _row("#6b4b3c", "#614236", 0.66, ("pores", 0.1, 0.3),
                           sheen=0.2, subsurface=1.0),
    "fair skin":      _row("#bd8d74", "#b68369", 0.68, ("pores", 0.1, 0.15),
                           sheen=0.3, subsurface=1.0),
    "tan skin":       _row("#a27559", "#9c6e53", 0.68, ("pores", 0.1, 0.15),
                           sheen=0.3, subsurface=1.0),
    "brown skin":     _row("#87624f", "#805b48", 0.66, ("pores", 0.1, 0.15),
                           sheen=0.25, subsurface=1.0),
    "fur":            _row("#8a6542", "#6d4d31", 0.9,  ("fur", 0.32, 0.25), sheen=0.5),
    "brown fur":      _row("#4d3322", "#38251a", 0.85, ("fur", 0.32, 0.25), sheen=0.5),
    "chestnut fur":   _row("#6e3a1c", "#562b14", 0.7, ("fur", 0.16, 0.10), sheen=0.3),
    "sand fur":       _row("#b88d58", "#a1763f", 0.85, ("fur", 0.32, 0.25), sheen=0.5),
    "grey fur":       _row("#77716a", "#5e5a55", 0.85, ("fur", 0.32, 0.25), sheen=0.5),
    "black fur":      _row("#1d1917", "#2b2420", 0.7,  ("fur", 0.32, 0.25), sheen=0.4),
    "white fur":      _row("#ddd8cf", "#c2b9a8", 0.85, ("fur", 0.32, 0.25), sheen=0.5),
    "red fur":        _row("#a3501f", "#7d3814", 0.8,  ("fur", 0.32, 0.25), sheen=0.5),
    "feathers":       _row("#2b2725", "#3d3632", 0.8,  ("plumage", 0.5, 1.0), sheen=0.3),
    "white feathers": _row("#dcdad4", "#c5c1b6", 0.8,  ("plumage", 0.5, 1.0), sheen=0.3),
    "horn":           _row("#332b24", "#4c4033", 0.6,  ("wood", 0.25, 1.0), clearcoat=0.05),
    "leather":        _row("#4a2f1f", "#5c3d29", 0.5,  ("pores", 0.25, 1.5), clearcoat=0.1),
    "black leather":  _row("#161517", "#1f1d1f", 0.4,  ("pores", 0.25, 1.5), clearcoat=0.3),
    "eye":            _row("#08080a", None,      0.08, None, clearcoat=1.0),
    "eye white":      _row("#9c9188", None,      0.7,  None, clearcoat=0.15),
    "brown iris":     _row("#4a2a12", None,      0.12, None, clearcoat=1.0),
    "blue iris":      _row("#466f8f", None,      0.12, None, clearcoat=1.0),
    "green iris":     _row("#56703f", None,      0.12, None, clearcoat=1.0),
    "red cloth":      _cloth("#9c2f2b"),
    "blue cloth":     _cloth("#2c4a73"),
    "green cloth":    _cloth("#3d5f3a"),
    "white cloth":    _cloth("#d6d1c4"),
    "black cloth":    _cloth("#232326"),
    "grey cloth":     _cloth("#77787a"),
    "yellow cloth":   _cloth("#c1913a"),
    "denim":          _row("#3b4f6e", "#455876", 0.88, ("weave", 0.07, 0.35), sheen=0.25),
    "navy cloth":     _cloth("#1f2a44"),
    "teal cloth":     _cloth("#2f6f6d"),
    "pink cloth":     _cloth("#c98a93"),
    "orange cloth":   _cloth("#b8602c"),
    "plum cloth":     _cloth("#5d3550"),
    "beige cloth":    _cloth("#a8916f"),
    "lips":           _row("#a8594c", None,      0.4,  None, clearcoat=0.2),
    "dark lips":      _row("#5f2f28", None,      0.4,  None, clearcoat=0.2),
}
"""Materials of creatures and clothes."""

THINGS: dict[str, Row] = {
    "wood":                 _row("#9a6b3f", "#6e4526", 0.55, ("wood", 0.5, 0.6)),
    "oak":                  _row("#a67c4b", "#8a6238", 0.5,  ("wood", 0.5, 0.6)),
    "walnut":               _row("#573722", "#402717", 0.4,  ("wood", 0.5, 0.6), clearcoat=0.2),
    "pine":                 _row("#c99b63", "#b98650", 0.6,  ("wood", 0.5, 0.6)),
    "ebony":                _row("#2a211c", "#1c1613", 0.35, ("wood", 0.5, 0.6), clearcoat=0.3),
    "wood floor":           _row("#9a6b3f", "#7d532f", 0.45, ("planks", 1.6, 1.0), clearcoat=0.15),
    "clay":                 _row("#b0643f", "#9c5232", 0.85, ("clay", 0.4, 1.0)),
    "terracotta":           _row("#bf6a3e", "#d08a5e", 0.9,  ("clay", 0.4, 1.0)),
    "porcelain":            _row("#e4e2dc", None,      0.15, None, clearcoat=1.0),
    "brick":                _row("#98482f", "#7d3a26", 0.9,  ("clay", 0.3, 3.0)),
    "concrete":             _row("#8f8d88", "#7c7a75", 0.9,  ("plaster", 1.0, 1.5)),
    "stone":                _row("#85796c", "#9c9184", 0.85, ("rock", 0.9, 1.0)),
    "marble":               _row("#d9d5cd", "#cfc8be", 0.18, ("marble", 0.6), clearcoat=0.5),
    "brass":                _row("#d9a94a", "#c6943a", 0.28, ("brushed", 0.3, 1.0), metallic=1.0),
    "copper":               _row("#c8744f", "#b0603e", 0.3,  ("brushed", 0.3, 1.0), metallic=1.0),
    "steel":                _row("#b4b8bd", "#a5aab0", 0.25, ("brushed", 0.3, 1.0), metallic=1.0),
    "bronze":               _row("#9c7042", "#7f6a46", 0.35, ("brushed", 0.3, 1.0), metallic=1.0),
    "gold":                 _row("#e3b04b", None,      0.2,  None, metallic=1.0),
    "silver":               _row("#d8d8d6", None,      0.18, None, metallic=1.0),
    "iron":                 _row("#5c5a58", "#6e5a4c", 0.55, ("mottle", 0.4, 1.0), metallic=0.9),
    "rust":                 _row("#7a4022", "#a3602e", 0.9,  ("soil", 0.5, 0.5)),
    "red painted metal":    _row("#9e1f1a", "#8c1a17", 0.35, ("scratches", 0.4, 1.0),
                                 clearcoat=0.6),
    "blue painted metal":   _row("#1f4a85", "#1b4176", 0.35, ("scratches", 0.4, 1.0),
                                 clearcoat=0.6),
    "yellow painted metal": _row("#d09a1c", "#bd8a18", 0.35, ("scratches", 0.4, 1.0),
                                 clearcoat=0.6),
    "green painted metal":  _row("#2f6b45", "#295e3c", 0.35, ("scratches", 0.4, 1.0),
                                 clearcoat=0.6),
    "white painted metal":  _row("#d8d8d4", "#cbcac4", 0.35, ("scratches", 0.4, 1.0),
                                 clearcoat=0.6),
    "glass":                _row("#f4f8f6", None,      0.0,  None, transmission=1.0, ior=1.5),
    "green glass":          _row("#8fc79a", None,      0.0,  None, transmission=1.0, ior=1.5),
    "blue glass":           _row("#86b0dd", None,      0.0,  None, transmission=1.0, ior=1.5),
    "amber glass":          _row("#e0a45a", None,      0.0,  None, transmission=1.0, ior=1.5),
    "frosted glass":        _row("#e6efec", None,      0.35, None, transmission=1.0, ior=1.5),
    "rubber":               _row("#262628", "#303033", 0.75, ("plaster", 0.3)),
    "red rubber":           _row("#b2261f", None,      0.5,  None, clearcoat=0.15),
    "white plaster":        _row("#dcd9d2", "#d8d5cd", 0.9,  ("plaster", 1.0, 1.0)),
    "grey plaster":         _row("#8b8a87", "#878683", 0.9,  ("plaster", 1.0, 1.0)),
    "red plastic":          _row("#b3231c", None,      0.3,  None, clearcoat=0.5),
    "blue plastic":         _row("#22569c", None,      0.3,  None, clearcoat=0.5),
    "yellow plastic":       _row("#d9a818", None,      0.3,  None, clearcoat=0.5),
    "white plastic":        _row("#d4d3cf", None,      0.3,  None, clearcoat=0.5),
    "black plastic":        _row("#1c1c1e", None,      0.3,  None, clearcoat=0.5),
    "flame":                _row("#ff7417", None,      1.0,  None, glow=2.5),
    "smoke":                _row("#a3a19d", None,      1.0,  None),
    "water":                _row("#a9c4d4", None,      0.08, None, clearcoat=1.0),
    "leaf":                 _row("#637d2b", "#75852f", 0.65, ("mottle", 0.2), clearcoat=0.1),
}
"""Materials of things."""

GROUNDS: dict[str, Row] = {
    "dry soil":         _row("#917d67", "#b3a48c", 0.95, ("soil", 2.6, 1.0), steep_color="#85766a"),
    "grass":            _row("#57672f", "#788042", 0.9,  ("grass", 1.9, 1.0),
                             steep_color="#7d7264"),
    "moss":             _row("#4e5e28", "#787a40", 0.95, ("moss", 1.1, 0.9),
                             steep_color="#6d6a64"),
    "sand":             _row("#cfae7b", "#dcc193", 0.9,  ("sand", 2.2, 0.8), steep_color="#b78f5f"),
    "pale sand":        _row("#b3a382", "#c9bb9f", 0.95, ("sand", 2.2, 1.1), steep_color="#a08b6c"),
    "snow":             _row("#e9edf2", "#dfe6ef", 0.7,  ("snow", 2.4, 0.6),
                             steep_color="#706d6c", steep_deg=40),
    "rock":             _row("#81766a", "#b3a89b", 0.85, ("rock", 2.9, 0.9)),
    "dark soil":        _row("#4a382a", "#5f4a38", 0.95, ("soil", 2.6, 1.0), steep_color="#6a6058"),
    "mud":              _row("#4b3a2a", "#5b4936", 0.3,  ("mud", 2.2, 1.0), clearcoat=0.4),
    "gravel":           _row("#837d75", "#8f8678", 0.9,  ("gravel", 1.8, 1.0),
                             steep_color="#7a736b"),
    "asphalt":          _row("#3c3c3e", "#48474a", 0.85, ("asphalt", 1.0, 0.8)),
    "ice":              _row("#a9c8d6", "#c3d8e0", 0.12, ("ice", 2.5, 1.0), clearcoat=0.8),
    "sea":              _row("#1f3f4a", "#24505a", 0.12, ("waves", 9.0, 1.0)),
    "tiles":            _row("#b9b0a2", "#aca190", 0.3,  ("tiles", 2.4, 1.0), clearcoat=0.3),
    "terracotta tiles": _row("#a9603c", "#9a5433", 0.5,  ("tiles", 2.4, 1.0)),
    "checker tiles":    _row("#8b8880", None,      0.22, ("checker", 2.4, 1.0), clearcoat=0.4),
}
"""Materials of the ground."""

# fmt: on

PALETTE: dict[str, Row] = {**CREATURES, **THINGS, **GROUNDS}
