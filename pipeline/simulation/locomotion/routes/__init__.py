"""Where creatures go, how fast, and how their bodies follow the ground."""
