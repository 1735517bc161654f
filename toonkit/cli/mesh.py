"""`toonkit mesh`: write the shape of an analyzed drawing for 3-D programs."""

from __future__ import annotations

import argparse
from typing import Any

from toonkit.cli.folders import read_analysis

BACKS = ("none", "mirrored", "flat")
"""`toonkit.export.mesh.BACKS`, repeated so that the help does not have to import it."""

VERTICES = 512
"""`toonkit.export.mesh.MOST_VERTICES`, repeated for the same reason."""


def add_mesh_command(commands: Any) -> None:
    """Add `mesh` to the parser's commands."""
    mesh = commands.add_parser("mesh", help="write the shape of an analyzed drawing as a .glb file")
    mesh.add_argument("analysis", help="the folder that `toonkit analyze` wrote, or its analysis.npz")
    mesh.add_argument("-o", "--out", required=True, metavar="FILE", help="file to write, .glb")
    mesh.add_argument(
        "--back",
        choices=BACKS,
        default="none",
        help="what is behind the surface: nothing (default), the same surface mirrored, or a plane; the latter two close it",
    )
    mesh.add_argument(
        "--size",
        type=float,
        default=1.0,
        metavar="LENGTH",
        help="length of the object's longest side in the units of the file (default: 1)",
    )
    mesh.add_argument(
        "--vertices",
        type=int,
        default=VERTICES,
        metavar="N",
        help=f"vertices along that side, at most (default: {VERTICES})",
    )
    mesh.add_argument("--quiet", action="store_true", help="no summary")
    mesh.set_defaults(run=_mesh)


def _mesh(arguments: argparse.Namespace) -> int:
    from toonkit.export.mesh import write_mesh  # noqa: PLC0415

    analysis = read_analysis(arguments.analysis)
    write_mesh(analysis, arguments.out, back=arguments.back, size=arguments.size, vertices=arguments.vertices)
    if not arguments.quiet:
        print(f"written to {arguments.out}")
    return 0
