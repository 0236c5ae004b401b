"""People: how they are made and what they look like, whoever moves them."""
