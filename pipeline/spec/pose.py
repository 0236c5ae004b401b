"""Pose: what an author asks of the joints and limbs of a figure at certain times (Sims, 3.2.2)."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from pipeline.spec.faults import Fault, refuse
from pipeline.spec.keyframes import Place, SmoothEase, Time, Turn
from pipeline.spec.values import Name, Number, Whole, Words
from render.config.base import EASE_DESCRIPTION, TURN_DESCRIPTION

Frame = Literal["feet", "body", "world"]

GOALS = ("reach", "aim", "turn_deg")
"""What can be asked of the end of a limb, or of one of its nodes."""


class BodyKey(Words):
    """Where the body is to be, relative to where its walking or standing has it."""

    move: Place = Field(
        (0.0, 0.0, 0.0), description="Forward, up and to the right of its heading [m]."
    )
    turn_deg: Turn = Field(
        (0.0, 0.0, 0.0), description=f"About its forward x, up y and right z: {TURN_DESCRIPTION}."
    )


class PoseKey(Words):
    """What is asked for at one time; between keys it goes along splines."""

    at: Time = Field(description="When it is to be so [s].")
    limb: Name | None = Field(
        None, description="The limb whose tip is asked for, such as arm_r1, l2 or head."
    )
    node: Name | None = Field(
        None, description="Instead of a limb: the node of its drawing that is asked for."
    )
    reach: Place | None = Field(None, description="Where the tip or node is to be [m].")
    aim: Place | None = Field(
        None, description="Where the link that ends there is to point, as a direction."
    )
    turn_deg: Turn | None = Field(
        None, description=f"How that link is turned from the way it was drawn: {TURN_DESCRIPTION}."
    )
    frame: Frame = Field(
        "feet",
        description="What reach, aim and turn_deg are relative to: feet (the ground below the "
        "body, x ahead, y up, z to the right), body, or world.",
    )
    priority: Annotated[Whole, Field(ge=1, le=9)] | None = Field(
        None,
        description="1 comes first; what comes later gets what the joints have left. 1 for "
        "limbs and nodes, 2 for joints, if left out.",
    )
    weight: Annotated[Number, Field(gt=0, le=1000)] = Field(
        1.0, description="Share in a compromise with what else has this priority."
    )
    joints: dict[Name, Number] | None = Field(
        None,
        min_length=1,
        description="Values by joint: elbow_r_deg turns the joint at the node elbow_r, "
        "hip_l_pitch_deg one of several there [degrees]; without _deg one that slides [m].",
    )
    body: BodyKey | None = Field(None, description="Where the body is to be.")
    release: Name | None = Field(
        None, description="A limb, node, joint or `body` that goes back to what it did by itself."
    )
    blend: Annotated[Number, Field(ge=0, le=1000)] = Field(
        0.5,
        description="How long the first key takes over from what was done before, ending at `at`, "
        "and how long a release takes, beginning there [s].",
    )
    ease: SmoothEase = Field("spline", description=f"{EASE_DESCRIPTION}.")

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        faults = []
        asked = [word for word in GOALS if getattr(self, word) is not None]
        named = [word for word in ("limb", "node") if getattr(self, word) is not None]
        if len(named) == 2:
            faults.append(Fault(("node",), "give either limb or node, not both", at_key=True))
        if asked and not named:
            faults.append(Fault((asked[0],), "say of which limb or node", at_key=True))
        if named and not asked:
            faults.append(Fault((named[0],), f"say what it is to do: {' or '.join(GOALS)}"))
        if self.aim is not None and self.turn_deg is not None:
            faults.append(Fault(("aim",), "give either aim or turn_deg, not both", at_key=True))
        if self.aim == (0.0, 0.0, 0.0):
            faults.append(Fault(("aim",), "points nowhere; give a direction such as [0, -1, 0]"))
        if not (asked or named or self.joints or self.body or self.release):
            faults.append(Fault((), "should have limb, node, joints, body or release"))
        refuse(faults)
        return self
