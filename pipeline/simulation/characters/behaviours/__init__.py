"""Behaviours: what characters do by themselves, one file each (Horswill 2008)."""
