"""Story: the director inside a scene, which plays beats by the state of the simulation."""
