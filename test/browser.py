# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The system's Chromium without a window, for pages that must work in a real browser."""

from contextlib import contextmanager
import shutil
import time

import pytest

_BROWSERS = ('chromium', 'chromium-browser', 'google-chrome')
_TIMEOUT_S = 300.0  # a loaded machine draws slowly


@contextmanager
def open_page(path):
    """Yield a Selenium driver that shows the file; skips without Chromium and its driver."""
    browser = next((found for name in _BROWSERS if (found := shutil.which(name))), None)
    driver = shutil.which('chromedriver')
    if browser is None or driver is None:
        pytest.skip('no Chromium with chromedriver; apt-get install chromium chromium-driver')
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service

    options = webdriver.ChromeOptions()
    options.binary_location = browser
    for argument in (
        *('--headless=new', '--no-sandbox', '--disable-gpu', '--disable-dev-shm-usage'),
        *('--window-size=1500,1800', '--hide-scrollbars'),
        # Nothing may be fetched: every name resolves to nowhere.
        '--host-resolver-rules=MAP * ~NOTFOUND, EXCLUDE localhost',
    ):
        options.add_argument(argument)
    options.set_capability('goog:loggingPrefs', {'browser': 'ALL'})
    session = webdriver.Chrome(options=options, service=Service(driver))
    try:
        session.command_executor.client_config.timeout = _TIMEOUT_S
        session.set_script_timeout(_TIMEOUT_S)
        session.get(path.resolve().as_uri())
        yield session
    finally:
        session.quit()


def wait_for(session, condition):
    """Wait until a JavaScript expression is true."""
    deadline = time.monotonic() + _TIMEOUT_S
    while not session.execute_script(f'return {condition}'):
        assert time.monotonic() < deadline, f'never true: {condition}'
        time.sleep(0.05)
