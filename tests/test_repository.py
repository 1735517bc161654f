"""Facts about the repository itself: import layers, style, packaging, and what its texts promise."""

from __future__ import annotations

import importlib.util
import json
import os
import pkgutil
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

import toonkit
from toonkit.estimation.weights import provenance
from toonkit.export.picture import write_picture

ROOT = Path(__file__).parent.parent
PYPROJECT: dict[str, Any] = tomllib.loads((ROOT / "pyproject.toml").read_text())
PROJECT: dict[str, Any] = PYPROJECT["project"]
README = (ROOT / "README.md").read_text()
DOCUMENTS = (*sorted(ROOT.glob("*.md")), *sorted((ROOT / "docs").rglob("*.md")))
CONSTRAINTS = [
    line for line in (ROOT / "constraints.txt").read_text().splitlines() if not line.lstrip().startswith("#")
]
CONDA_NAMES = {"pytorch": "torch", "python-build": "build"}
"""Name of a package on conda-forge -> its name on the Python index, where they differ."""

HEAVY_PACKAGES = (
    "panel",
    "panel_material_ui",
    "holoviews",
    "bokeh",
    "pyvista",
    "vtk",
    "trimesh",
    "matplotlib",
    "pandas",
    "dask",
)


def run_tool(name: str, *arguments: str) -> None:
    """Run a development tool of this Python's environment at the root; its complaint becomes the failure."""
    scripts = Path(sys.executable).parent
    tool = shutil.which(name, path=f"{scripts}{os.pathsep}{os.environ.get('PATH', '')}")
    assert tool is not None, f"{name} is not installed: pip install '.[test]'"
    done = subprocess.run([tool, *arguments], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def requirements(lines: list[str]) -> dict[str, str]:
    """Package name -> version bounds, of requirement lines such as 'numpy>=2.0'."""
    split = [re.fullmatch(r"([A-Za-z0-9._-]+)\s*(.*)", line) for line in lines]
    return {found[1].lower().replace("_", "-"): found[2] for found in split if found}


def test_every_module_imports_only_what_its_layer_allows() -> None:
    run_tool("lint-imports", "--no-cache")


def test_ruff_finds_nothing_to_complain_about() -> None:
    run_tool("ruff", "check", "--no-cache", ".")


def test_ruff_would_format_nothing_differently() -> None:
    run_tool("ruff", "format", "--no-cache", "--check", ".")


def test_mypy_strict_proves_the_types_of_the_package() -> None:
    run_tool("mypy")


def test_importing_toonkit_loads_no_drawing_library() -> None:
    code = "import sys, toonkit; print(*sorted({name.partition('.')[0] for name in sys.modules}))"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert set(done.stdout.split()).isdisjoint(HEAVY_PACKAGES)


def test_every_public_name_exists() -> None:
    code = "import toonkit; print(*(name for name in toonkit.__all__ if not hasattr(toonkit, name)))"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert done.stdout.split() == []


def test_every_folder_of_modules_is_a_package() -> None:
    folders = {path.parent for path in (ROOT / "toonkit").rglob("*.py")}
    assert sorted(str(f.relative_to(ROOT)) for f in folders if not (f / "__init__.py").is_file()) == []


def test_every_data_file_of_the_package_is_installed_with_it() -> None:
    package = ROOT / "toonkit"
    patterns = PYPROJECT["tool"]["setuptools"]["package-data"]["toonkit"]
    installed = {path for pattern in patterns for path in package.glob(pattern)}
    files = {path for path in package.rglob("*") if path.is_file() and path.parent.name != "__pycache__"}
    assert sorted(str(path) for path in files - installed if path.suffix != ".py") == []


def test_every_data_pattern_of_the_package_matches_a_file() -> None:
    patterns = PYPROJECT["tool"]["setuptools"]["package-data"]["toonkit"]
    assert [pattern for pattern in patterns if not any((ROOT / "toonkit").glob(pattern))] == []


def test_conda_and_pip_install_the_same_packages() -> None:
    conda = yaml.safe_load((ROOT / "environment.yml").read_text())
    from_conda = [line for line in conda["dependencies"] if isinstance(line, str) and line != "pip"]
    from_conda = [
        CONDA_NAMES.get(name := re.split("[>=]", line)[0], name) + line[len(name) :] for line in from_conda
    ]
    (from_pip,) = (entry["pip"] for entry in conda["dependencies"] if isinstance(entry, dict))
    assert "-e ." in from_pip
    wanted = ["python" + PROJECT["requires-python"], *PROJECT["dependencies"]]
    wanted += [
        line
        for extra in ("test", "study", "training", "docs")
        for line in PROJECT["optional-dependencies"][extra]
    ]
    assert requirements([*from_conda, *(line for line in from_pip if line != "-e .")]) == requirements(wanted)


def test_the_conda_recipe_needs_what_the_wheel_needs() -> None:
    recipe = yaml.safe_load((ROOT / "conda-recipe" / "recipe.yaml").read_text())
    wanted = ["python" + PROJECT["requires-python"], *PROJECT["dependencies"]]
    assert requirements(recipe["requirements"]["run"]) == requirements(wanted)
    assert recipe["package"] == {"name": PROJECT["name"], "version": toonkit.__version__}
    scripts = [f"{name} = {target}" for name, target in PROJECT["scripts"].items()]
    assert recipe["build"]["python"]["entry_points"] == scripts
    assert recipe["about"]["license"] == PROJECT["license"]


def pinned() -> dict[str, list[str]]:
    """Package name -> the versions that constraints.txt gives it, one for each of its environment markers."""
    versions: dict[str, list[str]] = {}
    for line in CONSTRAINTS:
        name, version = line.partition(";")[0].strip().split("==")
        versions.setdefault(canonicalize_name(name), []).append(version)
    return versions


def test_constraints_are_exact_versions_of_the_public_index() -> None:
    name, version = (
        r"[A-Za-z0-9._-]+",
        r"[0-9][0-9a-z.!]*",
    )  # no address, no hash, no local version such as +cpu
    unlike = [line for line in CONSTRAINTS if not re.fullmatch(rf"{name}=={version}( ; .+)?", line)]
    assert CONSTRAINTS
    assert unlike == []


def test_constraints_hold_every_dependency_within_its_bounds() -> None:
    extras = PROJECT["optional-dependencies"].values()
    lines = [*PROJECT["dependencies"], *(line for extra in extras for line in extra)]
    wanted = [Requirement(line) for line in (*lines, *PYPROJECT["build-system"]["requires"])]
    versions = pinned()
    assert [one.name for one in wanted if canonicalize_name(one.name) not in versions] == []
    assert [
        f"{one} is pinned to {version}"
        for one in wanted
        for version in versions[canonicalize_name(one.name)]
        if version not in one.specifier
    ] == []


def test_the_build_is_pinned_because_constraints_do_not_reach_it() -> None:
    assert [len(re.findall("==", line)) for line in PYPROJECT["build-system"]["requires"]] == [1]


def test_what_readme_installs_is_what_the_tests_ran_with() -> None:
    installs = re.findall(r"pip install (.*)", README)
    assert installs
    assert [line for line in installs if not line.startswith("-c constraints.txt ")] == []


def test_readme_serves_by_the_command_that_listens_to_this_machine_only() -> None:
    assert " && .venv/bin/toonkit dashboard\n" in README
    assert "panel serve" not in README


def test_notebooks_are_committed_without_output() -> None:
    cells = [
        (path.name, cell)
        for path in sorted((ROOT / "notebooks").rglob("*.ipynb"))
        if ".ipynb_checkpoints" not in path.parts
        for cell in json.loads(path.read_text())["cells"]
    ]
    assert [name for name, cell in cells if cell.get("outputs") or cell.get("execution_count")] == []


def test_the_citation_and_the_changelog_carry_the_version_of_the_package() -> None:
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    released = re.findall(r"^## \[(\d[^\]]*)\]", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE)
    assert {str(citation["version"]), released[0]} == {toonkit.__version__}


@pytest.mark.parametrize("marker", ["dashboard command", "test command"])
def test_readme_holds_each_of_its_two_commands_as_one_line(marker: str) -> None:
    blocks = re.findall(rf"^<!-- {marker} -->\n```bash\n(.*?)\n```$", README, re.MULTILINE | re.DOTALL)
    assert [block.count("\n") for block in blocks] == [0]


def test_the_python_of_readme_relights_a_drawing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rows, columns = np.mgrid[-24:25, -24:25]
    disc = rows**2 + columns**2 <= 20**2
    ramp = toonkit.ColorMap(np.array([[0.2, 0.1, 0.3], [0.8, 0.5, 0.4], [1.0, 0.9, 0.7]]), (-1.0, 1.0))
    drawing = toonkit.shade(toonkit.inflate(disc), toonkit.light_direction(135, 45), ramp)
    monkeypatch.chdir(tmp_path)
    write_picture(drawing, "drawing.png")
    (code,) = re.findall(r"^```python\n(.*?)^```$", README, re.MULTILINE | re.DOTALL)
    exec(compile(code, "README.md", "exec"), {})
    relit = toonkit.load_image("relit.png")
    assert np.array_equal(relit.mask, disc)
    assert toonkit.color_rmse(relit, drawing) > 0.05  # the light went from the upper left to the upper right


def test_ci_runs_the_test_command_of_readme_and_no_other() -> None:
    script = (ROOT / ".ci" / "run").read_text()
    assert os.access(ROOT / ".ci" / "run", os.X_OK)
    assert "<!-- test command -->" in script
    assert re.search(r"\bpip\b|\bpytest -|apt-get", script) is None


def test_readme_is_read_in_two_minutes() -> None:
    assert len(README.splitlines()) <= 120


def anchors(document: Path) -> set[str]:
    """Names by which GitHub links to the headings of a document."""
    headings = re.findall(r"^#+ (.*)$", document.read_text(), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.name)
def test_every_file_and_heading_that_a_document_links_to_exists(document: Path) -> None:
    links = re.findall(r"\]\(([^)\s]+)\)|<img src=\"([^\"]+)\"", document.read_text())
    missing = []
    for link in {address or picture for address, picture in links}:
        name, _, anchor = link.partition("#")
        target = document.parent / name if name else document
        if "://" not in link and not (target.exists() and (not anchor or anchor in anchors(target))):
            missing.append(link)
    assert links
    assert missing == []


@pytest.mark.parametrize("document", DOCUMENTS, ids=lambda path: path.name)
def test_every_module_and_function_that_a_document_names_exists(document: Path) -> None:
    text = document.read_text()
    commands = set(re.findall(r"python -m ([\w.]+)", text)) - {"build", "sphinx"}  # extras, not ours
    assert sorted(name for name in commands if importlib.util.find_spec(name) is None) == []
    for name in set(re.findall(r"`(toonkit(?:\.\w+)+)", text)):
        pkgutil.resolve_name(name)  # raises if there is none


def test_each_threat_names_tests_that_exist() -> None:
    rows = [row for row in (ROOT / "SECURITY.md").read_text().splitlines() if row.startswith("| ")][1:]
    named = [re.findall(r"`(test_\w+)`", row) for row in rows]
    written = "\n".join(path.read_text() for path in (ROOT / "tests").rglob("test_*.py"))
    existing = set(re.findall(r"^def (test_\w+)", written, re.MULTILINE))
    assert len(rows) > 10
    assert [row for row, names in zip(rows, named, strict=True) if not names] == []
    assert [name for names in named for name in names if name not in existing] == []


def test_development_says_how_long_the_networks_were_trained() -> None:
    text = " ".join((ROOT / "docs" / "development.md").read_text().split())
    stages, hours = {}, {}
    for name in ("shape", "light"):
        made = provenance(f"{name}_prior")
        trainings = [*made["started from"], made]
        stages[name], hours[name] = len(trainings), sum(part["seconds"] for part in trainings) / 3600
    assert f"trained in {stages['shape']} stages" in text
    assert stages["shape"] == stages["light"]
    assert (
        f"network took {hours['shape']:.1f} hours in total, the light network {hours['light']:.1f} hours"
        in text
    )
    colored = provenance("colored_shape_prior")
    later = [*colored["started from"][stages["shape"] :], colored]
    assert f"took {sum(part['seconds'] for part in later) / 3600:.1f} hours more" in text
