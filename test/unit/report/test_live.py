# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The page of a live run: what it is told, who may ask, and a real browser that follows."""

from dataclasses import replace
from http.client import HTTPConnection
import json
from urllib.parse import urlsplit

from browser import open_page, wait_for
import pytest

from fpnet.cli import main
from fpnet.report import write_run_report
from fpnet.report.live import LiveRun, RecordedRun
from fpnet.report.moments import MAX_MOMENTS
from fpnet.report.page import read_content
from fpnet_core.errors import FpnetError


@pytest.fixture
def live(made_up_run):
    with LiveRun('a <drive>', made_up_run.plan, 0) as live:
        yield live


def asked(live, path='/', host=None):
    place = urlsplit(live.url)
    connection = HTTPConnection(place.hostname, place.port, timeout=10)
    connection.request('GET', path, headers={} if host is None else {'Host': host})
    return connection.getresponse()


def told(stream):
    """The next event of a stream."""
    while not (line := stream.readline()).startswith(b'data: '):
        assert line, 'the stream has ended'
    return json.loads(line.removeprefix(b'data: '))


def until(run, count):
    return replace(run, outputs=run.outputs[:count], truth=None)


def test_whoever_opens_it_is_told_all_so_far_and_then_each_tick(live, made_up_run):
    live.show(until(made_up_run, 1))
    stream = asked(live, '/events')
    assert stream.getheader('Content-Type') == 'text/event-stream'
    first = told(stream)
    assert first['kind'] == 'run'
    assert [m['status'] for m in first['data']['moments']] == ['waiting']
    live.show(until(made_up_run, 2))
    second = told(stream)
    assert (second['kind'], second['moment']['status']) == ('update', 'ambiguous')
    assert len(second['changes']) == 2
    assert second['timeline']['data']
    live.end('it is over')
    assert told(stream) == {'kind': 'end', 'said': 'it is over'}
    assert told(asked(live, '/events'))['said'] == 'it is over'


def test_poses_are_told_once(live, made_up_run):
    poses = made_up_run.published
    none = replace(poses, stamps_ns=poses.stamps_ns[:0], xy=poses.xy[:0], yaw=poses.yaw[:0])
    live.show(replace(until(made_up_run, 2), published=none))
    stream = asked(live, '/events')
    assert told(stream)['data']['published']['x'] == []
    live.show(until(made_up_run, 3))
    assert len(told(stream)['published']['x']) == 2
    live.show(until(made_up_run, 3))
    assert told(stream)['published']['x'] == []


def test_rooms_that_are_cut_anew_take_the_page_and_keep_the_run(live, made_up_run):
    live.show(replace(until(made_up_run, 1), title=''))
    stream = asked(live, '/events')
    told(stream)
    live.show(replace(until(made_up_run, 2), title='', plan=replace(made_up_run.plan)))
    assert [told(stream)['kind'] for _ in range(2)] == ['reload', 'update']
    assert b'a &lt;drive&gt;' in asked(live).read()
    assert len(told(asked(live, '/events'))['data']['moments']) == 2


def test_a_page_that_is_open_for_days_stays_small(live, made_up_run):
    [first] = until(made_up_run, 1).outputs
    outputs = tuple(replace(first, stamp_ns=k) for k in range(2 * MAX_MOMENTS + 2))
    stream = asked(live, '/events')
    for count in range(1, len(outputs) + 1):
        live.show(replace(until(made_up_run, 1), outputs=outputs[:count]))
    events = [told(stream) for _ in range(len(outputs) + 2)]
    thinned = events[-2]
    assert [event['kind'] for event in events[-3:]] == ['update', 'run', 'update']
    assert len(thinned['data']['moments']) == MAX_MOMENTS
    assert len(told(asked(live, '/events'))['data']['moments']) == MAX_MOMENTS + 1


def test_it_serves_one_page_to_this_machine_and_nothing_else(live):
    page = asked(live)
    assert page.status == 200
    assert "default-src 'none'" in page.getheader('Content-Security-Policy')
    assert b'a &lt;drive&gt;' in page.read()
    for path in ('/etc/passwd', '/../../etc/passwd', '/report.html', '/?a=1'):
        assert asked(live, path).status == 404, path
    for host in ('evil.example', 'evil.example:80', f'0.0.0.0:{urlsplit(live.url).port}'):
        assert asked(live, '/', host).status == 403, host
    assert urlsplit(live.url).hostname == '127.0.0.1'


def test_a_port_that_is_taken_is_one_line(live, made_up_run):
    port = urlsplit(live.url).port
    with pytest.raises(FpnetError, match=f'port {port} of 127.0.0.1 is taken'):
        LiveRun('another', made_up_run.plan, port)


@pytest.fixture
def folder(made_up_run, tmp_path):
    write_run_report(tmp_path / 'run' / 'report.html', made_up_run)
    return tmp_path / 'run'


def test_a_recorded_run_comes_again_moment_by_moment(folder):
    with RecordedRun(folder / 'report.html', 0) as recorded:
        page = asked(recorded).read()
        assert b'<dd>3.2 m</dd>' in page, 'the figures of the run'
        stream = asked(recorded, '/events')
        assert told(stream)['data']['moments'] == []
        assert list(recorded) == [0.0, 1.0, 2.0]
        seen = [told(stream) for _ in range(3)]
    assert [event['moment']['status'] for event in seen] == ['waiting', 'ambiguous', 'localized']
    assert [len(event['changes']) for event in seen] == [1, 2, 3]


@pytest.mark.parametrize('text', ['', '<html></html>', 'AAAA', None])
def test_what_is_no_report_is_one_line(text, tmp_path):
    path = tmp_path / 'report.html'
    if text is not None:
        inside = f'<script type="text/plain" id="content">{text}</script>' if text else text
        path.write_text(inside)
    with pytest.raises(FpnetError, match=r'report\.html'):
        read_content(path)


def test_the_command_shows_a_recorded_run_and_ends_with_it(folder, capsys):
    with pytest.raises(SystemExit) as ended:
        main(['view', str(folder), '--rate', '0', '--port', '0', '--end'])
    assert not ended.value.code
    assert 'watch it at http://127.0.0.1:' in capsys.readouterr().err


def test_a_recording_needs_a_floorplan(tmp_path, capsys):
    with pytest.raises(SystemExit) as ended:
        main(['view', str(tmp_path)])
    assert ended.value.code == 1
    assert 'or a recording with --floorplan' in capsys.readouterr().err


@pytest.mark.apart
def test_a_browser_follows_until_somebody_goes_back(live, made_up_run, tmp_path):
    blank = tmp_path / 'blank.html'
    blank.write_text('<title>blank</title>')
    with open_page(blank) as browser:
        browser.get(live.url.replace('127.0.0.1', 'localhost'))  # all else is nowhere
        wait_for(browser, "document.body.dataset.ready === 'true'")
        for count in (1, 2):
            live.show(until(made_up_run, count))
        shown = "document.getElementById('status').textContent === "
        wait_for(browser, shown + "'ambiguous'")
        browser.execute_script(
            "const s = document.getElementById('slider'); s.value = 0;"
            "s.dispatchEvent(new Event('input'));"
        )
        live.show(until(made_up_run, 3))
        wait_for(browser, "document.getElementById('slider').max === '2'")
        wait_for(browser, "document.getElementById('answer').textContent.startsWith('localized')")
        status = browser.execute_script("return document.getElementById('status').textContent")
        assert status == 'waiting', 'who looks back is not torn away'
        live.end('over')
        wait_for(browser, "document.getElementById('answer').textContent === 'over'")
        assert [entry for entry in browser.get_log('browser') if entry['level'] == 'SEVERE'] == []
