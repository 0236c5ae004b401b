"""When feet go up and come down, how fast and how high: gaits, paces and moods."""
