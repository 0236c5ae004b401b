"""Dances of walking persons: orders, joint values of the arms, and the trunk."""
