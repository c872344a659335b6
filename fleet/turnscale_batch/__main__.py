# SPDX-License-Identifier: MIT
"""Started by `turnscale batch`, as `python3 turnscale_batch ARGUMENTS`."""
import importlib.util
import os
import pathlib
import sys

DEBIAN_PYTHON = "/usr/bin/python3"


def _require_modules():
    if all(importlib.util.find_spec(name) for name in ("cloudpickle", "dask", "distributed", "numpy", "yaml")):
        return
    # A Python of the user's own does not see Debian's packages.
    if os.access(DEBIAN_PYTHON, os.X_OK) and not os.path.samefile(sys.executable, DEBIAN_PYTHON):
        os.execv(DEBIAN_PYTHON, [DEBIAN_PYTHON, *sys.argv])
    from turnscale_batch.errors import InputError
    raise InputError("batch needs Dask; install the Debian packages python3-dask, python3-distributed and "
                     "python3-numpy")


def start():
    here = pathlib.Path(__file__).resolve().parent
    # As a package, whose modules do not hide others of their names.
    sys.path[:] = [str(here.parent)] + [path for path in sys.path if pathlib.Path(path or ".").resolve() != here]
    from turnscale_batch.cli import main
    return main(sys.argv[1:], _require_modules)


if __name__ == "__main__":
    exit_code = start()
    sys.stdout.flush()
    sys.stderr.flush()
    # Dask's own clean-up at exit may wait for what is gone; everything has been closed.
    os._exit(exit_code)
