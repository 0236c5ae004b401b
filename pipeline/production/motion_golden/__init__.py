"""Motion golden: a digest of a take to keep in version control, and what to compare with it.

A take is identical to its golden if the digest of its motion agrees, bit for bit. That is
asked only on the class of processor and with the libraries that the golden was made with.
Everywhere a take also passes that lies within a stated tolerance of the golden's rounded
numbers; the verdict says which of the two rules applied.
"""

from pipeline.production.motion_golden.comparison import compare
from pipeline.production.motion_golden.digest import motion_digest
from pipeline.production.motion_golden.file import read_golden, write_golden
from pipeline.production.motion_golden.golden import MotionGolden, golden_of
from pipeline.production.motion_golden.verdict import Difference, Outcome, Verdict

__all__ = [
    "Difference",
    "MotionGolden",
    "Outcome",
    "Verdict",
    "compare",
    "golden_of",
    "motion_digest",
    "read_golden",
    "write_golden",
]
