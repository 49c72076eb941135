# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Vector files are read in this process, where it is not their own process that is tested."""

import pytest

from fpnet_core.drawings.formats import worker
from fpnet_core.errors import MapFormatError


@pytest.fixture
def own_process():
    """Have files read in a process of their own, as everybody else does."""


@pytest.fixture(autouse=True)
def _read_here(request, monkeypatch):
    if 'own_process' not in request.fixturenames:
        monkeypatch.setattr(worker, 'read_apart', _read)


def _read(path, kind, options):
    try:
        return worker.unpack(worker.pack(worker.read_here(path, kind, options)))
    except MapFormatError:
        raise
    except Exception as error:
        facts = {'kind': kind, 'path': str(path)}
        raise MapFormatError(worker._damaged(facts, error)) from None
