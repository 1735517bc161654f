"""The examples in docstrings do what they say."""

from __future__ import annotations

import doctest
import importlib
import os
from pathlib import Path

import pytest

import toonkit

PACKAGE = Path(toonkit.__file__).parent
MODULES = sorted(
    ".".join(path.relative_to(PACKAGE.parent).with_suffix("").parts).removesuffix(".__init__")
    for path in PACKAGE.rglob("*.py")
    if ">>> " in path.read_text()
)
EXAMPLES = [
    example
    for name in MODULES
    for example in doctest.DocTestFinder().find(importlib.import_module(name))
    if example.examples
]


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda example: example.name)
def test_an_example_does_what_it_says(example, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    told: list[str] = []
    failed, _ = doctest.DocTestRunner().run(example, out=told.append)
    assert not failed, os.linesep.join(told)


def test_there_are_examples():
    assert "toonkit.methods.analyze" in {example.name for example in EXAMPLES}
