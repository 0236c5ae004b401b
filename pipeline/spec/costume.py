"""Costumes: names of what people wear, and the hair on their heads."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Literal

from pydantic import Field

from pipeline.spec.model_base import ConfigModel, MaterialName, Number

# fmt: off
Costume = Literal[
    "casual", "summer", "office", "hoodie", "coat", "dress", "skirt", "suit", "sport", "workwear",
]
# fmt: on

COSTUME_TEXTS: Mapping[Costume, str] = {
    "casual": "a shirt with short sleeves over jeans",
    "summer": "a shirt with short sleeves over shorts",
    "office": "a shirt tucked into trousers",
    "hoodie": "a top with a hood",
    "coat": "a coat down to above the knees",
    "dress": "a dress of one colour",
    "skirt": "a blouse and a skirt",
    "suit": "a jacket over a shirt with a tie",
    "sport": "a tracksuit with stripes",
    "workwear": "dungarees over a shirt",
}
"""All costumes, with what they are."""

COSTUMES: tuple[Costume, ...] = tuple(COSTUME_TEXTS)

HairStyle = Literal["short", "bob", "bun", "long", "none"]
"""How hair is worn."""


class HairLook(ConfigModel):
    """The hair on a person's head; what is left out follows from its name and the scene's seed."""

    style: HairStyle | None = Field(None, description="How it is worn; none is a bald head.")
    material: MaterialName | None = Field(
        None, description="Its material, and that of the brows: a fur of some colour."
    )
    length: Annotated[Number, Field(ge=0.3, le=2.5)] = Field(
        1.0, description="Factor on the length of its strands."
    )
