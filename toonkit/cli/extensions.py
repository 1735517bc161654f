"""Python files of a user's own, which register further methods and shapes."""

from __future__ import annotations

import importlib.util
import sys
from contextlib import suppress

from toonkit._validation import expand_home, refuse
from toonkit.methods import METHODS


def load_extension(file: str) -> list[str]:
    """
    Run a Python file, so that what it registers is known.

    Parameters
    ----------
    file : str
        The file. Its functions travel to workers by value: they need not have it.

    Returns
    -------
    list of str
        The methods that the file registered or replaced in `toonkit.METHODS`.

    Raises
    ------
    ToonkitError
        If there is no such file, or it ends in an error.
    """
    path = expand_home(file)
    if not path.is_file():
        raise refuse("--with", "must be a Python file", file)
    name = f"toonkit_extension_{path.stem}"
    specification = importlib.util.spec_from_file_location(name, path)
    if specification is None or specification.loader is None:
        raise refuse("--with", "must be a Python file, ending in .py", file)
    module = importlib.util.module_from_spec(specification)
    sys.modules[name] = module
    before = dict(METHODS)
    try:
        specification.loader.exec_module(module)
    except Exception as error:  # whatever the file does wrong
        raise refuse(
            "--with", "must run without an error", f"{file} ({type(error).__name__}: {error})"
        ) from error
    with suppress(ImportError):  # without dask nothing travels
        import cloudpickle  # noqa: PLC0415

        cloudpickle.register_pickle_by_value(module)
    return [method for method, function in METHODS.items() if before.get(method) is not function]
