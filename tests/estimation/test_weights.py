"""The weights that ship: small, whole, and with a record of how they were made."""

from __future__ import annotations

import io
import shlex
from importlib.resources import as_file, files

import numpy as np
import pytest

from toonkit.estimation import weights
from toonkit.estimation.weights import MOST_STEPS, packed, provenance, read_weights, weights_in
from toonkit.training.__main__ import _parser

NAMES = pytest.mark.parametrize("name", ["shape_prior", "colored_shape_prior", "light_prior"])


def test_the_weights_of_all_networks_together_take_eight_megabytes_at_most() -> None:
    with as_file(files(weights)) as folder:
        sizes = [path.stat().st_size for path in folder.glob("*.npz")]
    assert len(sizes) == 3
    assert sum(sizes) <= 8 * 1024**2


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


def test_packed_weights_are_read_to_within_half_a_step() -> None:
    rng = np.random.default_rng(3)
    given = {"stem.weight": rng.normal(size=(5, 4, 3, 3)), "stem.bias": rng.normal(size=5)}
    given["stem.weight"][2] = 0.0  # a map that nothing makes
    file = io.BytesIO()
    np.savez(
        file,
        allow_pickle=False,
        **packed({name: values.astype(np.float32) for name, values in given.items()}),
    )
    file.seek(0)
    read = weights_in(file)
    assert list(read) == list(given)
    steps = np.abs(given["stem.weight"]).max(axis=(1, 2, 3)) / MOST_STEPS
    apart = np.abs(read["stem.weight"] - given["stem.weight"]).max(axis=(1, 2, 3))
    assert (apart <= 0.51 * steps).all()
    assert read["stem.bias"] == pytest.approx(given["stem.bias"], rel=1e-3)
