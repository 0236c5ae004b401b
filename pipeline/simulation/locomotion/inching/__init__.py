"""Inchworms: figures of one chain, which walk on their ends in turns."""
