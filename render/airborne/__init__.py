"""What is in the air between the camera and the surfaces that it sees, besides haze."""
