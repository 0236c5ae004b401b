"""How feet go from one foothold to the next."""
