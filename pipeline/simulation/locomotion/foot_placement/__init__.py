"""Foot placement: the ground that supports creatures, the reach of their legs, their footholds."""
