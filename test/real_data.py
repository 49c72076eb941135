# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Where the real recordings are: ``$FPNET_DATA``, else ``../shared/data`` beside the repository.

Who sets the variable expects them: what is missing there fails the tests that need it, and they
are skipped only where nobody has said anything.
"""

import os
from pathlib import Path

import pytest

NAMED = os.environ.get('FPNET_DATA', '')
ROOT = Path(__file__).resolve().parents[1]
DATA = Path(NAMED).resolve() if NAMED else ROOT.parent / 'shared' / 'data'


def needs(*folders, data=DATA, is_expected=bool(NAMED)):
    """Return the mark of tests on some data sets; raises where they are expected and absent."""
    absent = [str(data / name) for name in folders if not (data / name).is_dir()]
    if absent and is_expected:
        raise FileNotFoundError(f'FPNET_DATA is set, and there is no {", ".join(absent)}')
    return pytest.mark.skipif(bool(absent), reason=f'absent: {", ".join(absent)}')
