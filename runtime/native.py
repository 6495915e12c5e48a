"""The compiled libraries, loaded at first use, with a readable error where the system lacks what they link to."""

from __future__ import annotations

import importlib
import os
import sys
from functools import cache
from importlib.machinery import PathFinder
from importlib.util import find_spec, module_from_spec
from types import ModuleType

from ..langs.diagnostics import Error

_SINGLE_THREADED = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
_PACKAGES = {"libgomp.so": "libgomp1", "libGL.so": "libgl1", "libstdc++.so": "libstdc++6"}


class MissingLibrary(Error):
    """A compiled library cannot be loaded; `hint` says what to install."""

    def __init__(self, library: str, reason: str, hint: str, code: str | None = None) -> None:
        self.library = library
        self.reason = reason
        self.hint = hint
        super().__init__(f"{'' if code is None else code + ': '}cannot load {library}: {reason}")


@cache
def load_native(name: str, distribution: str) -> ModuleType:
    """Import the compiled module `name` of the Python package `distribution`. Raises MissingLibrary."""
    try:
        return importlib.import_module(name)
    except ImportError as error:
        reason = str(error)
        package = next((p for library, p in _PACKAGES.items() if library in reason), None)
        if package is not None:
            hint = f"install the system library: sudo apt-get install {package}"
        else:
            hint = f"install it again: pip install --force-reinstall {distribution}"
        raise MissingLibrary(name, reason, hint) from error


def load_part(package: str, name: str) -> ModuleType | None:
    """The module `name` of a package without all that the package itself loads; None where that cannot be."""
    whole = find_spec(package)
    *folders, _ = name.split(".")
    places = [os.path.join(place, *folders) for place in (whole and whole.submodule_search_locations) or ()]
    spec = PathFinder.find_spec(f"{package}.{name}", places)
    if spec is None or spec.loader is None:
        return None
    module = module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    except ImportError:  # where the package has yet to say where its own libraries are
        return None
    return module


def load_extra(name: str, extra: str) -> ModuleType:
    """Import the module `name` that the optional `extra` brings. Raises MissingLibrary."""
    try:
        return importlib.import_module(name)
    except ImportError as error:
        package = name.partition(".")[0]
        hint = f"install the extra: pip install 'tamplang[{extra}]'"
        raise MissingLibrary(package, str(error), hint, "S0015") from error


def load_pinocchio() -> ModuleType:
    """Pinocchio (rigid-body kinematics). Raises MissingLibrary."""
    return load_native("pinocchio", "pin")


def load_coal() -> ModuleType:
    """Coal (distances between shapes). Raises MissingLibrary."""
    return load_native("coal", "coal")


def use_one_thread() -> None:
    """Keep the numerical libraries, if they are not loaded yet, from threads of their own: the matrices here are too
    small for them, they steal time from other processes, and they change the last digits of results."""
    for variable in _SINGLE_THREADED:
        os.environ[variable] = "1"


def prefer_one_thread() -> None:
    """The same in a process that belongs to others: what its environment says counts, and where NumPy is loaded
    already, its threads are left alone."""
    if "numpy" not in sys.modules:
        for variable in _SINGLE_THREADED:
            os.environ.setdefault(variable, "1")
