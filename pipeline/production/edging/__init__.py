"""Edging: how a laid floor ends: its plan, its broken border, and what stands behind it."""
