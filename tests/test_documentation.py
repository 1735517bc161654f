"""The documentation site builds without a warning, its links resolve, and its guides do what they say."""

from __future__ import annotations

import importlib.util
import os
import re
import shlex
import shutil
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

import pytest
from PIL import Image

import toonkit
from docs.layer_diagram import draw_layers, layers
from toonkit.samples import sample_path

ROOT = Path(__file__).parent.parent
DOCS = ROOT / "docs"
GUIDES = (DOCS / "tutorial.md", *sorted(set((DOCS / "howto").glob("*.md")) - {DOCS / "howto" / "index.md"}))


class _Page(HTMLParser):
    """Addresses that a page refers to, and the names that others can refer to."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.addresses: list[str] = []
        self.names: set[str] = set()
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Collect what a tag refers to and what it is called."""
        found = dict(attrs)
        self.addresses += [value for name in ("href", "src") if (value := found.get(name))]
        self.names |= {value for name in ("id", "name") if (value := found.get(name))}


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of the built site."""
    if importlib.util.find_spec("sphinx") is None:
        pytest.skip("Sphinx is not installed: pip install '.[docs]'")
    shutil.rmtree(DOCS / "api", ignore_errors=True)  # pages of names that are public no longer
    folder = tmp_path_factory.mktemp("site")
    command = [
        sys.executable,
        "-m",
        "sphinx",
        "-W",
        "--keep-going",
        "-q",
        "-E",
        "-c",
        "docs",
        ".",
        str(folder),
    ]
    done = subprocess.run(
        command,
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | {"PYTHONWARNINGS": ""},
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return folder


def test_the_site_builds_without_a_warning(site: Path) -> None:
    assert "toonkit" in (site / "docs" / "index.html").read_text()


def test_every_link_within_the_site_resolves(site: Path) -> None:
    paths = [path for path in site.rglob("*.html") if "_static" not in path.parts]  # the theme's own template
    pages = {path: _Page(path.read_text()) for path in paths}
    broken = []
    for path, page in pages.items():
        for address in page.addresses:
            parts = urlsplit(address)
            if parts.scheme or parts.netloc:
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            known = pages[target].names if target in pages else {parts.fragment}
            if not target.exists() or (parts.fragment and unquote(parts.fragment) not in known):
                broken.append(f"{path.relative_to(site)}: {address}")
    assert len(pages) > 50
    assert broken == []


def test_each_public_name_has_a_page(site: Path) -> None:
    named = {path.stem.removeprefix("toonkit.") for path in (site / "docs" / "api").glob("toonkit.*.html")}
    assert sorted(set(toonkit.__all__) - named) == ["METHODS"]  # a dict, which the page itself describes


def blocks_of(guide: Path) -> list[tuple[str, str]]:
    """Return language and text of the code blocks of a page, without the indent of a list that one stands in."""
    found = re.findall(r"^( *)```(\w+)\n(.*?)^ *```$", guide.read_text(), re.MULTILINE | re.DOTALL)
    return [
        (language, re.sub(rf"^{indent}", "", text, flags=re.MULTILINE)) for indent, language, text in found
    ]


def run_commands(text: str) -> str:
    """Run the lines that call toonkit, except those that serve a page, need another machine or only print a study."""
    told = ""
    for line in text.splitlines():
        words = shlex.split(line, comments=True)
        left_out = words[1] == "dashboard" or words[1:3] == ["study", "report"] or "--scheduler" in words
        if words[0] != ".venv/bin/toonkit" or left_out:
            continue
        command = [sys.executable, "-m", "toonkit", *words[1:]]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode == 0, line + done.stdout + done.stderr
        told += done.stdout + done.stderr
        if Path("first/materials.png").exists():
            shutil.copy("first/materials.png", "labels.png")  # what the reader corrects in a paint program
    return told


@pytest.mark.parametrize("guide", GUIDES, ids=lambda path: path.stem)
def test_a_guide_does_what_it_says(guide: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    monkeypatch.setitem(toonkit.METHODS, "flattened", toonkit.METHODS["lumo"])  # a guide replaces it
    blocks = blocks_of(guide)
    Path("my_method.py").write_text(next((text for language, text in blocks if language == "python"), ""))
    Path("drawings").mkdir()
    with Image.open(sample_path("cat")) as cat:
        small = cat.reduce(2)
    for name in ("drawing.png", "mask.png", "drawings/cat.png"):  # as a mask it is opaque on the object
        small.save(name)
    told, names = "", {}
    for language, text in blocks:
        if language == "bash":
            told += run_commands(text)
        elif language == "python":
            exec(compile(text, guide.name, "exec"), names)
        else:
            assert text in told
    assert blocks


def test_the_layer_diagram_shows_the_layers_that_are_checked() -> None:
    assert (DOCS / "figures" / "layers.svg").read_text() == draw_layers(layers())
