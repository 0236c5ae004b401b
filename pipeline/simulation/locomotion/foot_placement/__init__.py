"""Where feet can be put, and where they are put."""
