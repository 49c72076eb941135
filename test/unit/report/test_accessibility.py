# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""Reports and the page of a live run have nothing that axe or the browser's console objects to."""

from accessibility import axe, violations
from browser import open_page
import pytest

from fpnet.report import write_run_report
from fpnet.report.live import LiveRun

pytestmark = [pytest.mark.slow, pytest.mark.apart]
READY = "document.body.dataset.ready === 'true'"


@pytest.fixture(scope='module')
def browser(tmp_path_factory):
    axe()
    blank = tmp_path_factory.mktemp('blank') / 'blank.html'
    blank.write_text('<title>blank</title>')
    with open_page(blank) as session:
        yield session


def test_a_report_can_be_read_by_everybody(browser, made_up_run, tmp_path):
    write_run_report(tmp_path / 'report.html', made_up_run)
    assert list(violations(browser, (tmp_path / 'report.html').as_uri(), READY)) == []


def test_so_can_a_run_that_goes_on(browser, made_up_run):
    with LiveRun('a drive', made_up_run.plan, 0) as live:
        live.show(made_up_run)
        url = live.url.replace('127.0.0.1', 'localhost')  # all else is nowhere
        shown = f"{READY} && document.getElementById('status').textContent === 'localized'"
        assert list(violations(browser, url, shown)) == []


def test_what_cannot_be_read_is_found(browser, tmp_path):
    page = '<html><body><p style="color: #ccc">pale</p><img src="x.png"></body></html>'
    (tmp_path / 'page.html').write_text(page)
    found = ''.join(violations(browser, (tmp_path / 'page.html').as_uri(), 'true'))
    for rule in ('color-contrast', 'html-has-lang', 'image-alt', 'ERR_FILE_NOT_FOUND'):
        assert rule in found
