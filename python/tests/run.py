#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Runs the tests of the package that is installed, or in PYTHONPATH: all of them, or the modules that are named.

Without numpy it says so and exits with code 77: skipped.
"""
import pathlib
import sys
import unittest

try:
    import numpy  # noqa: F401
except ImportError:
    print("no numpy (Debian package: python3-numpy)")
    sys.exit(77)

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
names = sys.argv[1:] or ["test_drives", "test_errors"]
result = unittest.TextTestRunner(verbosity=2).run(unittest.defaultTestLoader.loadTestsFromNames(names))
sys.exit(0 if result.wasSuccessful() else 1)
