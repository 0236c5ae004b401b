"""Jumps of walking creatures, and their handover between walking and jumping."""
