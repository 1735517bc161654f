"""Where a study's numbers come from: inputs, networks, versions, commit, machine, and the runs that made them."""

from __future__ import annotations

import os
import platform
import subprocess
from dataclasses import asdict
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

import toonkit
from toonkit.estimation.refinement import MAX_SWEEPS, SWEEP_RELAXATION, SWEEP_TOLERANCE
from toonkit.study.digests import weights_digests
from toonkit.study.plan import StudyPlan
from toonkit.study.scenes import MeshShape

SHOWN_DIGITS = 12
"""How many digits of a digest or a commit are shown."""

_PACKAGES = ("numpy", "scipy", "scikit-image", "numba", "pandas", "dask", "distributed")


def provenance(plan: StudyPlan) -> dict[str, Any]:
    """Return, as JSON, what a study's numbers depend on."""
    return {
        "toonkit": toonkit.__version__,
        "settings": asdict(plan.settings),
        "refinement_as_printed": {
            "relaxation": SWEEP_RELAXATION,
            "max_sweeps": MAX_SWEEPS,
            "tolerance": SWEEP_TOLERANCE,
        },
        "shapes": {
            name: {
                "kind": scene.kind,
                "view": asdict(scene.view),
                **({"faces": len(scene.mesh.faces)} if isinstance(scene, MeshShape) else {}),
            }
            for name, scene in plan.scenes.items()
        },
        "color_maps": list(plan.color_maps),
        "methods": list(plan.methods),
        "light_tracks": list(plan.light_tracks),
        "digests": plan.digests(),
    }


def describe_machine() -> dict[str, Any]:
    """Return, as JSON, the commit, the versions and the machine that this process runs with."""
    return {
        "commit": _commit(),
        "versions": {"python": platform.python_version(), **{name: version(name) for name in _PACKAGES}},
        "machine": {"system": platform.platform(), "processor": _processor(), "cores": os.cpu_count()},
    }


@cache
def installed_toonkit() -> str:
    """Return in one line which toonkit this process runs, as found when first asked: version, commit and weights."""
    weights = ", ".join(f"{name} {digest[:SHOWN_DIGITS]}" for name, digest in weights_digests().items())
    return f"version {toonkit.__version__}, commit {_commit() or 'unknown'}, {weights}"


def _commit() -> str | None:
    """Return the commit of the checkout that this runs from, with a + if the package differs from it; None without one."""
    git = ["git", "-C", str(Path(toonkit.__file__).parent)]
    # Installed into an environment inside some other repository, the package is none of that one's files.
    tracked = _output([*git, "ls-files", "--error-unmatch", "__init__.py"])
    commit = _output([*git, "rev-parse", f"--short={SHOWN_DIGITS}", "HEAD"])
    if tracked is None or commit is None:
        return None
    return commit + ("+" if _output([*git, "status", "--porcelain", "--", "."]) else "")


def _output(command: list[str]) -> str | None:
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
