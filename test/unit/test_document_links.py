# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Links of the pages that MkDocs does not build lead somewhere."""

from pathlib import Path
import re

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.parametrize('name', ['README.md', 'CHANGELOG.md'])
def test_relative_links_lead_to_files(name):
    text = re.sub(r'```.*?```', '', (ROOT / name).read_text(encoding='utf-8'), flags=re.DOTALL)
    links = [link for link in re.findall(r'\]\(([^)#\s]+)', text) if '://' not in link]
    assert [link for link in links if not (ROOT / link).exists()] == []
