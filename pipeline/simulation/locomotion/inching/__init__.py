"""Figures of one chain, which walk by letting their ends take turns."""
