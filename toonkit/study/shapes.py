"""The twenty shapes of the study, and where to add one: a function under `@shape` in one of its modules."""

from toonkit.study.registry import BOUND, SHAPES, Shape, ShapeKind, View, shape
from toonkit.study.solids import creatures as _creatures  # noqa: F401  # each module registers its shapes
from toonkit.study.solids import objects as _objects  # noqa: F401
from toonkit.study.solids import primitives as _primitives  # noqa: F401

__all__ = ["BOUND", "SHAPES", "Shape", "ShapeKind", "View", "shape"]
