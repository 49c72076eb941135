# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Tests on real data are skipped where nobody expects it, and fail where somebody does."""

import pytest
from real_data import needs


def test_absent_data_skips_unless_it_is_expected(tmp_path):
    mark = needs('logs', data=tmp_path, is_expected=False)
    assert mark.args == (True,)
    assert 'logs' in mark.kwargs['reason']
    with pytest.raises(FileNotFoundError, match=r'FPNET_DATA is set, and there is no .*logs'):
        needs('logs', data=tmp_path, is_expected=True)


def test_data_that_is_there_is_tested(tmp_path):
    (tmp_path / 'logs').mkdir()
    for is_expected in (False, True):
        assert needs('logs', data=tmp_path, is_expected=is_expected).args == (False,)
