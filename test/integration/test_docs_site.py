# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The documentation as it is built: nothing that axe or the browser's console objects to."""

from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
import os
from pathlib import Path
import subprocess
import sys
from threading import Thread

from accessibility import axe, violations
from browser import open_page
import pytest

ROOT = Path(__file__).resolve().parents[2]
# One of each kind: text, tables, code, pictures, drawings of boxes, generated reference.
PAGES = ('', 'tutorial/', 'floorplans/', 'parameters/', 'ros/', 'python/', 'tour/', 'results/')

pytestmark = [pytest.mark.slow, pytest.mark.apart]


class Quiet(SimpleHTTPRequestHandler):
    def log_message(self, *_):
        pass


@pytest.fixture(scope='module')
def site(tmp_path_factory):
    """The address of the built documentation."""
    axe()
    folder = tmp_path_factory.mktemp('site')
    subprocess.run(
        [sys.executable, '-m', 'mkdocs', 'build', '--strict', '--quiet', '--site-dir', folder],
        cwd=ROOT,
        env={**os.environ, 'NO_MKDOCS_2_WARNING': '1'},
        check=True,
    )
    server = ThreadingHTTPServer(('127.0.0.1', 0), partial(Quiet, directory=folder))
    Thread(target=server.serve_forever, daemon=True).start()
    yield f'http://localhost:{server.server_port}/'
    server.shutdown()
    server.server_close()


@pytest.fixture(scope='module')
def browser(site, tmp_path_factory):
    blank = tmp_path_factory.mktemp('blank') / 'blank.html'
    blank.write_text('<title>blank</title>')
    with open_page(blank) as session:
        yield session


@pytest.mark.parametrize('page', PAGES)
def test_a_page_can_be_read_by_everybody(browser, site, page):
    labelled = "document.querySelector('.md-search').hasAttribute('aria-label')"
    assert list(violations(browser, f'{site}{page}', labelled)) == []
