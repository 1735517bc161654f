"""The study: shapes with known normals, painted with known color maps, and how well each method recovers them."""
