"""Direct: a scene that is stepped, asked and told what to do by another program."""
