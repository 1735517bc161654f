"""Digests: whether code, a shape, a color map or a method is still the one that an older record was made with."""

from __future__ import annotations

import ast
import functools
import hashlib
import inspect
import sys
import types
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

import toonkit
from toonkit.model.color_map import ColorMap
from toonkit.study.registry import BOUND, Shape
from toonkit.study.subjects import Subject

PACKAGE = Path(toonkit.__file__).parent

_NETWORKS = tuple(
    f"estimation/{name}.py"
    for name in ("convolution", "overview", "tone_ranks", "working_square", "weights/__init__")
)

_SHAPE = ("estimation/shape_prior.py", "estimation/weights/shape_prior.npz", *_NETWORKS)

PARTS = {
    "shape": _SHAPE,
    "light": (
        "estimation/light_prior.py", "estimation/light_fit.py", "estimation/weights/light_prior.npz", *_SHAPE,
    ),
    "refinement": (
        "estimation/edges.py",
        "numerics/unit_vectors.py",
        *(f"numerics/unit_field{part}.py" for part in ("", "_cycle", "_kernels", "_problem")),
    ),
    "smoothing": ("numerics/smoothing.py", "numerics/smoothing_kernels.py"),
}  # fmt: skip
"""Files in `toonkit/` that trials depend on only by a method that uses them, or by a light that is estimated: what was
learned of shapes and of lights, of which the learned shape is a judge, the solver of our own refinement, and Eq. 5 by it."""

_USED_BY = {
    "shape": ("shape_prior",),
    "light": ("light_fit", "light_prior"),
    "refinement": (".refined(", "shape_prior"),  # whose normals the solver's module makes unit vectors
    "smoothing": ("SmoothnessEnergy",),
}  # what a method's module says if it uses them

MEASURED_BY = (
    "_validation.py", "analysis.py", "metrics.py", "relighting.py", "model", "numerics", "methods/steps.py", "estimation",
    *(f"study/{name}" for name in ("contestants.py", "registry.py", "rendering.py", "subjects.py", "trials.py")),
    *(f"study/solids/{name}" for name in ("mesh_rays.py", "sphere_tracing.py")),
)  # fmt: skip
"""Modules that every trial depends on, in `toonkit/`, but for `PARTS`; methods and subjects have digests of their own."""

_PROBES = np.random.default_rng(0).uniform(-BOUND, BOUND, (4096, 3))
_PLAIN = (type(None), bool, int, float, complex, str, bytes)


def code_digest(package: Path = PACKAGE) -> str:
    """Return a digest of the code that measures every trial: comments, docstrings and layout do not count."""
    parts = {package / name for names in PARTS.values() for name in names}
    files: list[Path] = []
    for name in MEASURED_BY:
        path = package / name
        files += sorted(path.glob("*.py")) if path.is_dir() else [path]
    return _digest_of([file for file in files if file not in parts], package)


def part_digest(name: str, package: Path = PACKAGE) -> str:
    """Return a digest of one of `PARTS`: code and weights."""
    return _digest_of([package / file for file in PARTS[name]], package)


def _digest_of(files: list[Path], package: Path) -> str:
    digest = hashlib.sha256()
    for file in files:
        content = _bare(file).encode() if file.suffix == ".py" else file.read_bytes()
        digest.update(f"{file.relative_to(package)}\n".encode() + content)
    return digest.hexdigest()


def light_track_digests() -> dict[str, str]:
    """Return, for each light track, a digest of what was learned that its trials depend on."""
    return {"given": "", "estimated": PART_DIGESTS["light"]}


def subject_digest(subject: Subject) -> str:
    """Return a digest of what a subject looks like: its distances at fixed places or its triangles, and its view."""
    digest = hashlib.sha256(repr(subject.view).encode())
    if isinstance(subject, Shape):
        digest.update(np.round(subject.distance(_PROBES), 9).tobytes())
    else:
        digest.update(np.ascontiguousarray(subject.mesh.vertices, dtype=np.float64).tobytes())
        digest.update(np.ascontiguousarray(subject.mesh.faces, dtype=np.int64).tobytes())
    return digest.hexdigest()


def color_map_digest(color_map: ColorMap) -> str:
    """Return a digest of a color map's samples and domain; their last bits are another processor's own."""
    numbers = np.round(np.append(color_map.colors, color_map.domain), 9)
    return hashlib.sha256(numbers.tobytes()).hexdigest()


def method_digest(method: object) -> str:
    """
    Return a digest of a callable: its source, and what it closes over, calls beside itself, or was bound to.

    What it calls of toonkit is known by `CODE`, and of other packages by their versions. A method of toonkit itself is known
    by its module, and by those of `PARTS` that the module uses; any other may use all of them.
    """
    digest = hashlib.sha256()
    for name in PARTS:
        if _may_use(method, name):
            digest.update(PART_DIGESTS[name].encode())
    for piece in _pieces(method, {}):
        digest.update(f"{len(piece)}:".encode() + piece)
    return digest.hexdigest()


def _may_use(method: object, name: str) -> bool:
    """Tell whether a method may use one of `PARTS`."""
    if not (isinstance(method, types.FunctionType) and method.__module__.startswith("toonkit.")):
        return True
    file = sys.modules[method.__module__].__file__
    return file is None or any(word in _bare(Path(file)) for word in _USED_BY[name])


def _pieces(value: Any, seen: dict[int, Any]) -> Iterator[bytes]:
    """Yield, in a fixed order, the bytes that tell a value from another."""
    if isinstance(value, _PLAIN):
        yield repr(value).encode()
        return
    if id(value) in seen:
        return
    seen[id(value)] = value  # kept alive, or another could take its id
    yield f"{type(value).__module__}.{type(value).__qualname__}".encode()
    if isinstance(value, np.ndarray):
        yield f"{value.dtype}{value.shape}".encode() + np.ascontiguousarray(value).tobytes()
    elif isinstance(value, types.ModuleType):
        yield value.__name__.encode()
    elif isinstance(value, types.FunctionType):
        yield from _function_pieces(value, seen)
    elif isinstance(value, type):
        yield _source(value)
    elif isinstance(value, dict):
        for key in sorted(value, key=repr):
            yield from _all_pieces((key, value[key]), seen)
    elif isinstance(value, list | tuple):
        yield from _all_pieces(value, seen)
    elif isinstance(value, set | frozenset):
        yield from _all_pieces(sorted(value, key=repr), seen)
    elif isinstance(value, functools.partial):
        yield from _all_pieces((value.func, value.args, value.keywords), seen)
    elif isinstance(value, types.MethodType):
        yield from _all_pieces((value.__func__, value.__self__), seen)
    else:
        # A compiled function keeps its Python source; any other object is its class and what it holds.
        yield from _all_pieces(
            (getattr(value, "py_func", type(value)), dict(getattr(value, "__dict__", {}))), seen
        )


def _all_pieces(values: Any, seen: dict[int, Any]) -> Iterator[bytes]:
    for value in values:
        yield from _pieces(value, seen)


def _function_pieces(function: types.FunctionType, seen: dict[int, Any]) -> Iterator[bytes]:
    module = sys.modules.get(function.__module__)
    if function.__module__.startswith("toonkit.") and module is not None and module.__file__:
        yield _bare(Path(module.__file__)).encode()
        return
    yield _source(function)
    yield from _all_pieces((function.__defaults__, function.__kwdefaults__), seen)
    for cell in function.__closure__ or ():
        try:
            yield from _pieces(cell.cell_contents, seen)
        except ValueError:  # a name that is not bound yet
            yield b"unbound"
    for name in sorted(set(_names(function.__code__))):
        if name in function.__globals__:
            yield name.encode()
            yield from _global_pieces(function.__globals__[name], function.__module__, seen)


def _global_pieces(value: Any, module: str, seen: dict[int, Any]) -> Iterator[bytes]:
    """Follow what a function finds in its own module; what that imported is known by its name."""
    home = getattr(value, "__module__", module)
    if callable(value) and home != module:
        yield f"{home}.{getattr(value, '__qualname__', '')}".encode()
    else:
        yield from _pieces(value, seen)


def _names(code: types.CodeType) -> Iterator[str]:
    yield from code.co_names
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            yield from _names(constant)


def _source(thing: Any) -> bytes:
    try:
        return inspect.getsource(thing).encode()
    except (OSError, TypeError):  # typed at a prompt, or built in
        code = getattr(thing, "__code__", None)
        return thing.__qualname__.encode() if code is None else b"".join(_code_pieces(code))


def _code_pieces(code: types.CodeType) -> Iterator[bytes]:
    yield code.co_code + repr(code.co_names).encode()
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            yield from _code_pieces(constant)
        else:
            yield repr(constant).encode()


def _bare(file: Path) -> str:
    """Return a module's source without comments, docstrings and layout."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        if isinstance(body, list):
            # Strings that stand alone: docstrings, and those below constants and attributes.
            node.body = [line for line in body if not _is_text(line)]  # type: ignore[attr-defined]
    return ast.unparse(tree)


def _is_text(node: ast.AST) -> bool:
    return (
        isinstance(node, ast.Expr)
        and isinstance(node.value, ast.Constant)
        and isinstance(node.value.value, str)
    )


CODE = code_digest()
"""Digest of the code that runs: taken when it was imported, whatever became of the files since."""

PART_DIGESTS = {name: part_digest(name) for name in PARTS}
"""Digests of `PARTS`, taken likewise."""

EVERYTHING = hashlib.sha256("".join([CODE, *PART_DIGESTS.values()]).encode()).hexdigest()
"""Digest of all of it, in which all processes of a run must agree."""
