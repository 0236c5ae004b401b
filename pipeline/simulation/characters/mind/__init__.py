"""Minds: what characters notice, feel and want (Horswill 2008)."""
