"""Square jerk of the Macarena's subtasks as published in 1998.

The library's dance lists the matching durations. The force field could not turn a hand (subtasks 3
and 4).

Source: Matarić, Zordan and Mason 1998, figure 3.
"""

from __future__ import annotations

PAPER_SUBTASK_COUNT = 12

HUMAN = (85800, 89000, 1970, 5060, 18800, 21200, 141000, 111000, 68200, 65900, 71900, 12100)

TORQUE = (38500, 63400, 1010, 1930, 55200, 84100, 105000, 64000, 205000, 401000, 8990, 12800)

FORCE = (1100, 560, None, None, 360, 360, 22600, 7300, 14700, 3200, 20, 40)

PAPER_JERK: dict[str, tuple[int | None, ...]] = {"human": HUMAN, "torque": TORQUE, "force": FORCE}
"""Square jerk of each subtask by performer, printed with the unit m²/s⁶."""
