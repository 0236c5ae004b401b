"""Stepping: when feet lift, where they are to go, and creatures that find no foothold."""
