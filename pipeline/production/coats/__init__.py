"""Coats: hair and feathers on the hides of animals."""
