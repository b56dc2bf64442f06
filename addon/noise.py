# SPDX-License-Identifier: GPL-3.0-or-later
"""Keeps what libraries print out of the command line's output.

Blender and OpenVDB write to the process's own file descriptors, where JSON (stdout) and the one line of an
error (stderr) must stand alone.
"""

import contextlib
import os
import sys
import tempfile

from .errors import InputError


@contextlib.contextmanager
def hidden():
    """Catches everything written to descriptors 1 and 2 inside the block.

    Drops it, unless an exception that is neither the user's fault nor a cancellation leaves the block: then
    it goes to stderr, ahead of the traceback.
    """
    sys.stdout.flush()
    sys.stderr.flush()
    kept = [os.dup(1), os.dup(2)]
    with tempfile.TemporaryFile() as caught:
        try:
            os.dup2(caught.fileno(), 1)
            os.dup2(caught.fileno(), 2)
            yield
        except (InputError, KeyboardInterrupt):
            restore(kept)
            raise
        except BaseException:
            restore(kept)
            caught.seek(0)
            os.write(2, caught.read())
            raise
        else:
            restore(kept)


def restore(kept):
    """Gives descriptors 1 and 2 back to the files that `kept` duplicates."""
    sys.stdout.flush()
    sys.stderr.flush()
    for target, descriptor in zip((1, 2), kept, strict=True):
        os.dup2(descriptor, target)
        os.close(descriptor)
