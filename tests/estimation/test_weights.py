"""The weights that ship: small, whole, and with a record of how they were made."""

from __future__ import annotations

import shlex
from importlib.resources import as_file, files

import numpy as np
import pytest

from toonkit.estimation import weights
from toonkit.estimation.weights import provenance, read_weights
from toonkit.training.__main__ import _parser

NAMES = pytest.mark.parametrize("name", ["shape_prior", "light_prior"])


def test_the_weights_of_both_networks_together_take_five_megabytes_at_most() -> None:
    with as_file(files(weights)) as folder:
        sizes = [path.stat().st_size for path in folder.glob("*.npz")]
    assert len(sizes) == 2
    assert sum(sizes) <= 5 * 1024**2


@NAMES
def test_the_weights_are_those_that_the_record_speaks_of(name: str) -> None:
    arrays = read_weights(name)
    assert {values.dtype for values in arrays.values()} == {np.dtype(np.float32)}
    assert all(np.isfinite(values).all() for values in arrays.values())
    assert sum(values.size for values in arrays.values()) == provenance(name)["parameters"]


@NAMES
def test_the_record_names_a_command_that_there_is(name: str) -> None:
    made = provenance(name)
    program, _, arguments = made["command"].partition(" toonkit.training ")
    assert program == "python -m"
    given = _parser().parse_args(shlex.split(arguments))
    assert given.task == name.removesuffix("_prior")
    assert made["figures, degrees, on shapes kept aside"][-1]["step"] == given.steps
