# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""What axe and the browser's console find wrong with a page, in both widths and schemes."""

from collections.abc import Iterator
from importlib.util import find_spec
from itertools import product
from pathlib import Path

import pytest

WIDTHS = (1500, 390)
SCHEMES = ('light', 'dark')
# Packages that bring axe, the newest first.
PACKAGES = ('axe_playwright_python', 'axe_core_python')
RULES = ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'best-practice']
RUN = """
const done = arguments[arguments.length - 1];
axe.run(document, {runOnly: arguments[0]}).then((found) => done(found.violations.map(
  (each) => each.id + ': ' + each.nodes.map((node) => node.target.join(' ')).join(', '))));
"""


def axe() -> str:
    """Return axe's source; skips where nothing brings it."""
    for name in PACKAGES:
        if (found := find_spec(name)) is not None and found.origin is not None:
            return (Path(found.origin).parent / 'axe.min.js').read_text(encoding='utf-8')
    pytest.skip('no axe; pip install axe-core-python')


def violations(browser, url: str, is_ready: str) -> Iterator[str]:
    """Yield what is wrong with a page; ``is_ready`` is JavaScript that says when to look."""
    from browser import wait_for

    source = axe()
    for width, scheme in product(WIDTHS, SCHEMES):
        browser.execute_cdp_cmd(
            'Emulation.setDeviceMetricsOverride',
            {'width': width, 'height': 1000, 'deviceScaleFactor': 1, 'mobile': width < 500},
        )
        feature = {'name': 'prefers-color-scheme', 'value': scheme}
        browser.execute_cdp_cmd('Emulation.setEmulatedMedia', {'features': [feature]})
        browser.get(url)
        wait_for(browser, is_ready)
        browser.execute_script(source)
        where = f'{url.rpartition("/")[2] or url} at {width} px, {scheme}'
        for each in browser.execute_async_script(RUN, RULES):
            yield f'{where}: {each}'
        is_wide = 'document.documentElement.scrollWidth > document.documentElement.clientWidth'
        if browser.execute_script(f'return {is_wide}'):
            yield f'{where}: wider than the window'
    for entry in browser.get_log('browser'):
        if entry['level'] == 'SEVERE':
            yield f'{url}: {entry["message"]}'
