"""Plants and stones over the ground: shapes, species, places and the meshes made of them."""
