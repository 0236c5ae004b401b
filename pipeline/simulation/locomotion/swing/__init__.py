"""The swings of feet between footholds, and their contacts with the ground."""
