# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""
Take a screenshot of a report for the documentation.

Run: python tools/screenshot.py out/run/report.html docs/images/report.png
     [--width 1500] [--upto SELECTOR] [--at SECONDS]

Needs Chromium with its driver (apt-get install chromium chromium-driver). ``--upto`` crops the
image below the first element that matches a CSS selector, ``--at`` shows that time of a run.
"""

import argparse
import base64
import io
from pathlib import Path
import sys

from PIL import Image

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / 'test'))
from browser import open_page, wait_for

READY = "document.body.dataset.ready === 'true'"


def take(page: Path, width: int, upto: str, at: float | None) -> Image.Image:
    """Return a screenshot of a page, ``width`` pixels wide."""
    with open_page(page) as browser:
        size = {'width': width, 'height': 1000, 'deviceScaleFactor': 1, 'mobile': width < 500}
        browser.execute_cdp_cmd('Emulation.setDeviceMetricsOverride', size)
        browser.get(page.resolve().as_uri())
        wait_for(browser, READY)
        if at is not None:
            browser.execute_script('stop(); show(nearest(arguments[0]))', at)
        height = browser.execute_script(
            'const e = document.querySelector(arguments[0]);'
            'return Math.ceil(e.getBoundingClientRect().bottom + window.scrollY) + 12',
            upto,
        )
        clip = {'x': 0, 'y': 0, 'width': width, 'height': height, 'scale': 1}
        shot = browser.execute_cdp_cmd(
            'Page.captureScreenshot', {'clip': clip, 'captureBeyondViewport': True}
        )
    return Image.open(io.BytesIO(base64.b64decode(shot['data']))).convert('RGB')


def main() -> None:
    """Take the screenshot and save it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('page', type=Path)
    parser.add_argument('picture', type=Path)
    parser.add_argument('--width', type=int, default=1500)
    parser.add_argument('--upto', default='body')
    parser.add_argument('--at', type=float)
    arguments = parser.parse_args()
    image = take(arguments.page, arguments.width, arguments.upto, arguments.at)
    image.save(arguments.picture, optimize=True)


if __name__ == '__main__':
    main()
