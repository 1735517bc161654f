"""How the learned parts are trained: shapes and color maps of its own, two small networks (the `training` extra)."""
