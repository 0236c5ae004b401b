"""Drawing -> network -> skeleton; kinematics; inverse kinematics (Sims 1987, ch. 4 to 6)."""
