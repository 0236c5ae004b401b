"""Skin: words for the rendered surface of a figure alone; masses and motion do not know them."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from pipeline.spec.model_base import ConfigModel, Name, Number, Positive

Form = Literal["animal", "arthropod", "person", "plain"]
# fmt: off
SkullName = Literal[
    "horse", "deer", "giraffe", "camel", "kangaroo", "dog", "cat", "mouse", "elephant", "frog",
    "lizard", "bird",
]
# fmt: on
Hair = Literal["none", "hanging", "upright"]
TailName = Literal["plain", "hair", "tassel", "brush", "fan"]
HornName = Literal["straight", "curved", "lyre", "stub", "tusks"]
CoatName = Literal["none", "smooth", "sleek", "short", "long", "shaggy"]
PupilName = Literal["round", "slit", "bar"]
ShellName = Literal["plain", "beetle", "ant", "spider", "scorpion", "centipede", "crab"]
# fmt: off
Place = Literal[
    "belly", "back", "throat", "muzzle", "face", "ears", "mane", "legs", "shins", "feet", "arms",
    "tail", "tail tip", "neck", "body", "spots", "patches", "stripes",
]
# fmt: on

SkinColor = Annotated[
    str,
    Field(pattern="^#[0-9a-fA-F]{6}$", description="An sRGB colour, '#rrggbb'."),
]

Offset = Annotated[Number, Field(ge=-10, le=10)]
Extent = Annotated[Positive, Field(le=10)]


class Lump(ConfigModel):
    """A lump of flesh at a node: a hump, a crest, a cheek."""

    node: Name = Field(description="Node at which it is.")
    at: tuple[Offset, Offset, Offset] = Field(
        (0.0, 0.0, 0.0), description="How far ahead, up and to the right of it, in its radius."
    )
    radii: tuple[Extent, Extent, Extent] = Field(
        (1.0, 1.0, 1.0), description="Radii ahead, up and to the side, in the node's radius."
    )
    turn_deg: Annotated[Number, Field(ge=-180, le=180)] = Field(
        0.0, description="Turn in the plane of symmetry, front up [degrees]."
    )
    blend: Annotated[Number, Field(ge=0, le=5)] = Field(
        0.5, description="How softly it grows from what is around it, in the node's radius."
    )
    mirror: bool = Field(False, description="Whether there is another one on the other side.")
    carve: bool = Field(False, description="Whether it is taken away.")
    color: SkinColor | None = Field(
        None, description="Colour of the skin and the coat on it; that around it if left out."
    )


class Paint(ConfigModel):
    """A colour on a part of the skin, over that of the material."""

    where: Place = Field(description="Part of the skin, or a pattern over all of it.")
    color: SkinColor
    share: Annotated[Number, Field(ge=0, le=1)] = Field(1.0, description="How much it covers.")
    size: Extent | None = Field(
        None, description="Distance of spots, patches and stripes, in the body's radius."
    )
    hair: Annotated[Number, Field(ge=0, le=10)] = Field(
        1.0, description="Length of the coat there, in that around it."
    )


class Skin(ConfigModel):
    """The rendered surface of a figure; what is left out suits style and feet."""

    form: Form | None = Field(
        None,
        description="animal: one grown-together surface with muscles and a skull; arthropod: "
        "plates and segments; person: a dressed person on two legs, with two arms and a head above "
        "them; plain: the solids themselves. Chosen by style if left out.",
    )
    skull: SkullName | None = Field(
        None, description="Shape of an animal's head; chosen by its feet if left out."
    )
    shell: ShellName = Field("plain", description="Shape of an arthropod's body.")
    toes: Annotated[int, Field(ge=1, le=5)] | None = Field(
        None, description="Toes of a foot: 1 is a whole hoof, 2 a cloven one."
    )
    claws: bool = Field(True, description="Whether paws and spread toes have claws.")
    horns: HornName = Field("curved", description="Shape of an animal's horns.")
    mane: Hair = Field("none", description="Mane along the neck.")
    tail: TailName = Field("plain", description="What an animal's tail is made of.")
    tail_length: Extent = Field(
        1.0,
        description="Length of a plain tail, in that drawn: its tip goes on beyond the last node.",
    )
    coat: CoatName | None = Field(
        None,
        description="Hair or plumage of an animal, which grows on materials with the texture fur "
        "or plumage; chosen by its feet if left out.",
    )
    coat_length: Extent = Field(1.0, description="Length of the coat, in the usual one.")
    head_size: Extent = Field(1.0, description="Size of an animal's head, in that drawn.")
    ear_length: Extent = Field(1.0, description="Length of the ears, in the usual one.")
    ear_width: Extent = Field(1.0, description="Width of the ears, in the usual one.")
    eye_size: Extent = Field(1.0, description="Size of the eyes, in the usual one.")
    iris: SkinColor | None = Field(None, description="Colour of the iris.")
    pupil: PupilName | None = Field(
        None, description="Shape of the pupils: round, an upright slit, or a level bar."
    )
    whiskers: Annotated[Number, Field(ge=0, le=3)] | None = Field(
        None, description="Length of the whiskers, in that of the head; 0 for none."
    )
    lumps: Annotated[tuple[Lump, ...], Field(max_length=64)] = Field(
        (), description="More flesh, at nodes."
    )
    paint: Annotated[tuple[Paint, ...], Field(max_length=64)] = Field(
        (), description="Colours, the later over the earlier."
    )
