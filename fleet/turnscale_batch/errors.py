# SPDX-License-Identifier: MIT
"""Errors that end the program with one line, with its exit codes."""


class BatchError(Exception):
    """A failure of this side: exit code 1."""

    exit_code = 1


class InputError(BatchError):
    """Input that cannot be used: exit code 2."""

    exit_code = 2
