"""A sequence of scenes: their clips as one film with one sound."""
