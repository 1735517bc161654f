"""Where a study's numbers come from: code, versions, machine, and the runs that made them."""

from __future__ import annotations

import ast
import hashlib
import inspect
import os
import platform
import subprocess
from dataclasses import asdict
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

import toonkit
from toonkit.estimation.refinement import refine_as_printed
from toonkit.study.plan import StudyPlan
from toonkit.study.subjects import MeshShape

PACKAGE = Path(toonkit.__file__).parent

MEASURED_BY = (
    "_validation.py", "analysis.py", "metrics.py", "relighting.py", "model", "numerics", "estimation", "methods",
    *(f"study/{name}" for name in (
        "color_maps.py", "contestants.py", "registry.py", "rendering.py", "shapes.py", "solids", "subjects.py", "trials.py",
    )),
)  # fmt: skip
"""The modules that a trial's numbers depend on, in `toonkit/`."""

_PACKAGES = ("numpy", "scipy", "scikit-image", "numba", "pandas", "dask", "distributed")


@cache
def source_digest() -> str:
    """Return a digest of the code that measures: comments, docstrings and layout do not count."""
    digest = hashlib.sha256()
    for name in MEASURED_BY:
        path = PACKAGE / name
        for file in sorted(path.glob("*.py")) if path.is_dir() else [path]:
            digest.update(f"{file.relative_to(PACKAGE)}\n".encode())
            digest.update(ast.dump(_undocumented(ast.parse(file.read_text(encoding="utf-8")))).encode())
    return digest.hexdigest()


def provenance(plan: StudyPlan) -> dict[str, Any]:
    """Return, as JSON, all that a reader needs to repeat a study."""
    allowed = inspect.signature(refine_as_printed).parameters
    return {
        "toonkit": toonkit.__version__,
        "source": source_digest(),
        "commit": _commit(),
        "settings": asdict(plan.settings),
        "versions": {"python": platform.python_version(), **{name: version(name) for name in _PACKAGES}},
        "machine": {"system": platform.platform(), "processor": _processor(), "cores": os.cpu_count()},
        "refinement_as_printed": {
            name: allowed[name].default for name in ("relaxation", "max_sweeps", "tolerance")
        },
        "shapes": {
            name: {
                "kind": subject.kind,
                "view": asdict(subject.view),
                **({"faces": len(subject.mesh.faces)} if isinstance(subject, MeshShape) else {}),
            }
            for name, subject in plan.subjects.items()
        },
        "color_maps": list(plan.color_maps),
        "methods": list(plan.methods),
        "light_tracks": list(plan.light_tracks),
        "digests": plan.digests(),
    }


def _undocumented(tree: ast.Module) -> ast.Module:
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        if isinstance(body, list):
            # Strings that stand alone: docstrings, and those below constants and attributes.
            node.body = [line for line in body if not _is_text(line)]  # type: ignore[attr-defined]
    return tree


def _is_text(node: ast.AST) -> bool:
    return (
        isinstance(node, ast.Expr)
        and isinstance(node.value, ast.Constant)
        and isinstance(node.value.value, str)
    )


def _commit() -> str | None:
    """Return the commit of the checkout that this runs from, with a + if files differ from it; None without one."""
    command = ["git", "-C", str(PACKAGE), "describe", "--always", "--abbrev=12", "--dirty=+", "--exclude=*"]
    try:
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return None


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        return platform.processor()
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor()
