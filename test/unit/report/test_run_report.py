# SPDX-FileCopyrightText: 2026 The fpnet_ros developers
# SPDX-License-Identifier: Apache-2.0
"""The HTML report of a run: its values, its file, and its page in a real browser."""

from dataclasses import replace
from html.parser import HTMLParser
import json

from browser import open_page, wait_for
import numpy as np
from planted import A_PLAN_SUBMAP, plan_grid
import pytest

from fpnet_core.geometry import SE2
from fpnet_core.report import write_run_report
from fpnet_core.report.moments import MAX_MOMENTS, chosen_ticks
from fpnet_core.report.pictures import grid_picture
from fpnet_core.report.record import best_placement_errors, published_errors
from fpnet_core.trajectory import PlanarTrajectory
from fpnet_core.types import OCCUPIED, Cause, CauseKind, GridMap, LocalizerOutput, Status

MAX_BYTES = 10_000_000
MOVING = ('placement_0', 'placement_2', 'matches', 'published', 'robot')


class Page(HTMLParser):
    """What a page loads, and its embedded JSON by id."""

    def __init__(self, text):
        super().__init__()
        self.loaded, self.json, self.ids, self.attributes = [], {}, set(), {}
        self._json_id = None
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        attributes = dict(attrs)
        self.ids.add(attributes.get('id'))
        self.attributes[attributes.get('id')] = attributes
        self.loaded += [attributes[a] for a in ('src', 'href') if attributes.get(a)]
        if tag == 'script' and attributes.get('type') == 'application/json':
            self._json_id = attributes['id']

    def handle_data(self, data):
        if self._json_id is not None:
            self.json[self._json_id] = json.loads(data)
            self._json_id = None


@pytest.fixture(scope='module')
def report(made_up_run, tmp_path_factory):
    path = tmp_path_factory.mktemp('report') / 'new' / 'report.html'
    write_run_report(path, made_up_run)
    return path


@pytest.fixture(scope='module')
def page(report):
    return Page(report.read_text(encoding='utf-8'))


def test_it_is_one_file_that_loads_nothing(report, page):
    assert [url for url in page.loaded if not url.startswith('data:')] == []
    assert report.stat().st_size < MAX_BYTES
    text = report.read_text(encoding='utf-8')
    assert 'a &lt;drive&gt; on a plan' in text
    assert 'a <drive>' not in text


def test_it_shows_the_figures_with_their_units(report):
    text = report.read_text(encoding='utf-8')
    assert '<b>3.25</b><span>path to first pose [m]</span>' in text
    assert '<b>yes</b><span>localized</span>' in text
    assert 'wrong poses' not in text


def test_there_is_a_moment_for_each_tick(page):
    moments = page.json['data']['moments']
    assert [m['status'] for m in moments] == ['waiting', 'ambiguous', 'localized']
    assert [m['reason'] for m in moments] == [f'{k} placements' for k in (0, 2, 3)]
    assert [m['time_s'] for m in moments] == [0.0, 1.0, 2.0]
    assert page.attributes['slider']['max'] == '2'
    assert moments[0]['placements'] == []
    assert moments[0]['picture'] is None
    assert [p['score'] for p in moments[2]['placements']] == [0.9, 0.3, 0.2]
    assert [p['is_claimed'] for p in moments[2]['placements']] == [True, False, False]
    assert moments[2]['timings_ms']['verify'] == 30.0
    assert moments[1]['picture']['source'].startswith('data:image/png;base64,')


def test_matches_join_plan_and_submap_regions(page, made_up_run):
    match = page.json['data']['moments'][1]['matches'][0]
    plan, sub = made_up_run.plan, made_up_run.outputs[1].segmentation
    assert match['plan_xy'] == pytest.approx(plan.regions[match['plan_id']].centroid, abs=0.01)
    assert match['sub_xy'] == pytest.approx(sub.regions[match['sub_id']].centroid, abs=0.01)


def test_every_trace_that_the_script_moves_is_there(page):
    by_name = {
        name: {trace.get('meta') for trace in page.json[f'figure-{name}']['data']}
        for name in ('plan', 'submap')
    }
    assert set(MOVING) <= by_name['plan']
    assert {'doors', 'path', 'robot', 'labels'} <= by_name['submap']
    assert page.json['figure-timeline']['layout']['shapes'][0]['type'] == 'line'


def test_errors_are_in_true_metres(made_up_run):
    errors = published_errors(made_up_run)
    assert errors.position_m == pytest.approx([0.05, 0.05])
    assert errors.yaw_deg == pytest.approx([0.0, 0.0], abs=1e-6)
    assert best_placement_errors(made_up_run) == [None, *[pytest.approx(0.05, abs=1e-3)] * 2]


def test_a_run_without_truth_poses_or_ticks_has_a_report(made_up_run, tmp_path):
    nothing = PlanarTrajectory(np.zeros(0, np.int64), np.zeros((0, 2)), np.zeros(0))
    bare = replace(made_up_run, outputs=(), published=nothing, truth=None)
    write_run_report(tmp_path / 'bare.html', bare)
    page = Page((tmp_path / 'bare.html').read_text(encoding='utf-8'))
    assert page.json['data']['moments'] == []
    notes = page.json['figure-timeline']['layout']['annotations']
    assert 'no ground truth' in notes[0]['text']


def test_long_runs_are_thinned_out_but_changes_stay():
    statuses = [Status.SEARCHING] * 501 + [Status.AMBIGUOUS] + [Status.SEARCHING] * 600
    outputs = tuple(LocalizerOutput(k, status) for k, status in enumerate(statuses))
    chosen = chosen_ticks(outputs)
    assert len(chosen) <= MAX_MOMENTS
    assert {0, 501, 502, len(outputs) - 1} <= set(chosen)
    assert chosen == sorted(set(chosen))


def test_pictures_lie_where_their_grid_does():
    cells = np.zeros((40, 60), np.int8)
    cells[30:34, 10:14] = OCCUPIED
    grid = GridMap(cells, 0.1, SE2.from_xy_yaw(5.0, -3.0, np.deg2rad(90.0)))
    red = np.zeros((40, 60, 3), np.uint8)
    red[cells == OCCUPIED] = (255, 0, 0)
    picture = grid_picture(grid, red, 400)
    # Turned by a quarter: the grid's 6 m along x now go along y, its 4 m along -x.
    corner = (picture.x, picture.y, picture.width, picture.height)
    assert corner == pytest.approx((1.0, 3.0, 4.0, 6.0))
    rows, columns = np.nonzero(decoded(picture)[..., 0] > 128)
    x = picture.x + (columns.mean() + 0.5) * 0.1
    y = picture.y - (rows.mean() + 0.5) * 0.1
    expected = grid.rc_to_xy([31.5, 11.5])
    assert (x, y) == pytest.approx(expected, abs=0.051)


def test_large_pictures_shrink_and_keep_their_place():
    grid = plan_grid()
    picture = grid_picture(grid, np.zeros((*grid.shape, 3), np.uint8), 100)
    image = decoded(picture)
    assert max(image.shape[:2]) == 100
    assert picture.width > 40.0


def decoded(picture):
    import base64
    import io

    from PIL import Image

    data = base64.b64decode(picture.uri.split(',', 1)[1])
    return np.asarray(Image.open(io.BytesIO(data)).convert('RGBA'))


def test_the_slider_moves_everything_in_a_browser(report, made_up_run):
    with open_page(report) as browser:
        wait_for(browser, "document.body.dataset.ready === 'true'")

        def trace(chart, key, axis):
            return browser.execute_script(
                'const t = document.getElementById(arguments[0]).data'
                '.find((t) => t.meta === arguments[1]); return Array.from(t[arguments[2]]);',
                chart,
                key,
                axis,
            )

        def go_to(index):
            browser.execute_script(
                "const s = document.getElementById('slider'); s.value = arguments[0];"
                "s.dispatchEvent(new Event('input'));",
                index,
            )

        def text(element):
            return browser.execute_script(
                'return document.getElementById(arguments[0]).textContent', element
            )

        assert text('status') == 'localized'
        path = made_up_run.outputs[2].submap.path_xy
        expected = A_PLAN_SUBMAP.apply(path[-1])
        robot = [trace('plan', 'robot', axis)[0] for axis in 'xy']
        assert robot == pytest.approx(expected, abs=0.02)
        assert len(trace('plan', 'published', 'x')) == 2
        go_to(1)
        assert text('status') == 'ambiguous'
        assert 'best placement off by 0.05 m' in text('facts')
        assert len(trace('plan', 'placement_1', 'x')) > 100
        assert trace('plan', 'placement_2', 'x') == []
        assert len(trace('submap', 'path', 'x')) == 3
        go_to(0)
        assert text('status') == 'waiting'
        assert trace('plan', 'placement_0', 'x') == []
        browser.execute_script("document.getElementById('play').click()")
        wait_for(browser, "document.getElementById('slider').value === '2'")
        drawn = browser.execute_script(
            "return document.querySelectorAll('#plan .main-svg image, #submap image').length"
        )
        assert drawn == 2
        assert [entry for entry in browser.get_log('browser') if entry['level'] == 'SEVERE'] == []


def test_a_run_without_a_pose_names_its_causes(made_up_run, report, tmp_path):
    causes = (Cause(CauseKind.MIRRORED, 'fits <flipped>', 'fpnet localize a --mirrored'),)
    write_run_report(tmp_path / 'report.html', replace(made_up_run, causes=causes))
    text = (tmp_path / 'report.html').read_text(encoding='utf-8')
    assert '<b>drawing mirrored</b>: fits &lt;flipped&gt;.' in text
    assert '<code>fpnet localize a --mirrored</code>' in text
    assert 'Likely causes' not in report.read_text(encoding='utf-8')
