"""Pixels and vectors: the masked grid, its difference operators, and the solvers. Knows no cartoons."""
