"""Python files of a user's own, which register further methods and shapes."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

from toonkit._validation import refuse


def load_extension(file: str) -> None:
    """
    Run a Python file, so that what it registers is known.

    Parameters
    ----------
    file : str
        The file. Its functions travel to workers by value: they need not have it.

    Raises
    ------
    ToonkitError
        If there is no such file, or it ends in an error.
    """
    path = Path(file).expanduser()
    if not path.is_file():
        raise refuse("--with", "must be a Python file", file)
    name = f"toonkit_extension_{path.stem}"
    specification = importlib.util.spec_from_file_location(name, path)
    if specification is None or specification.loader is None:
        raise refuse("--with", "must be a Python file, ending in .py", file)
    module = importlib.util.module_from_spec(specification)
    sys.modules[name] = module
    try:
        specification.loader.exec_module(module)
    except Exception as error:  # whatever the file does wrong
        raise refuse(
            "--with", "must run without an error", f"{file} ({type(error).__name__}: {error})"
        ) from error
    try:
        import cloudpickle  # noqa: PLC0415
    except ImportError:  # without dask nothing travels
        return
    cloudpickle.register_pickle_by_value(module)
