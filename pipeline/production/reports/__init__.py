"""Plots and tables of a scene and its take."""
