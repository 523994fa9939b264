"""Bodies of a cell, of the part and its stock: shapes, meshes, and how far they are from each other."""
