"""Pixels and vectors: the masked grid, its difference operators, and the solvers. Knows no cartoons."""

from toonkit.numerics.cache_folder import ensure_cache_folder

ensure_cache_folder()
