"""Characters made of nodes and links (Horswill 2008)."""
