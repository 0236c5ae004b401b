"""Shots: meshes, materials, lights and camera of each frame, from a take and its scene."""
