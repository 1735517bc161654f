"""The twenty shapes of the study, and where to add one: a function under `@shape` in one of its modules."""

from toonkit.study import creatures as _creatures  # noqa: F401  # each module registers its shapes
from toonkit.study import objects as _objects  # noqa: F401
from toonkit.study import primitives as _primitives  # noqa: F401
from toonkit.study.registry import BOUND, SHAPES, Shape, ShapeKind, View, shape

__all__ = ["BOUND", "SHAPES", "Shape", "ShapeKind", "View", "shape"]
