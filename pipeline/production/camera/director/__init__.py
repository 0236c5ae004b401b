"""Director: decides the cuts of a film from what happens in its take."""
