# SPDX-License-Identifier: MIT
"""Keeps what Dask prints apart from the messages of the batch."""
import contextlib
import os
import sys

STDERR = 2


def _open(path):
    try:
        return os.open(path, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_APPEND, 0o666)
    except OSError:
        # The disk may be full.
        return os.open(os.devnull, os.O_WRONLY)


@contextlib.contextmanager
def stderr_in_file(path):
    """Until the end of the block, the error stream of this process, and of those that it starts, is the file. Yields the
    stream as it was. Dask reports the death of a worker with tracebacks, in several processes and in several ways; none
    of them is a message for the user. Removes the file if it is empty."""
    sys.stderr.flush()
    before = os.dup(STDERR)
    log = _open(path)
    os.dup2(log, STDERR)
    os.close(log)
    try:
        with open(before, "w", encoding=sys.stderr.encoding, errors=sys.stderr.errors, closefd=False) as stream:
            yield stream
    finally:
        with contextlib.suppress(OSError):
            sys.stderr.flush()
        os.dup2(before, STDERR)
        os.close(before)
        with contextlib.suppress(OSError):
            if os.path.getsize(path) == 0:
                os.unlink(path)
