const slider = document.getElementById('slider');
const FRAME_MS = 250;
const BEST = 0.6, FAINT = 0.2;

function traceIndex(name, key) {
  return document.getElementById(name).data.findIndex((trace) => trace.meta === key);
}

// Null separates lines.
function placed(A, xs, ys) {
  const row = (a) => xs.map((x, i) => x === null ? null : a[0] * x + a[1] * ys[i] + a[2]);
  return [row(A[0]), row(A[1])];
}

// Columns of the submap, turned to the axes of the floorplan; texts stay.
function turned(moment, columns) {
  const [c, s] = [Math.cos(moment.turn), Math.sin(moment.turn)];
  return [...placed([[c, -s, 0], [s, c, 0]], columns[0], columns[1]), ...columns.slice(2)];
}

function degrees(radians) {
  return radians * 180 / Math.PI;
}

function yawOf(A) {
  return Math.atan2(A[1][0], A[0][0]);
}

// Columns x, y and, where a trace has them, texts.
function update(name, columns) {
  const keys = Object.keys(columns);
  const change = {x: keys.map((key) => columns[key][0]), y: keys.map((key) => columns[key][1]),
    text: keys.map((key) => columns[key][2] || null)};
  return Plotly.restyle(name, change, keys.map((key) => traceIndex(name, key)));
}

// The robot is an arrow if its heading is known, hollow while its pose is not accepted; plotly
// rotates markers clockwise.
function turnRobot(name, heading, isAccepted) {
  const symbol = (heading === null ? 'circle' : 'arrow') + (isAccepted ? '' : '-open');
  const change = {'marker.symbol': symbol,
    'marker.angle': heading === null ? 0 : 90 - degrees(heading)};
  return Plotly.restyle(name, change, [traceIndex(name, 'robot')]);
}

function last(columns) {
  return [columns[0].slice(-1), columns[1].slice(-1)];
}

function matchLines(moment) {
  const lines = [[], []];
  const best = moment.placements[0];
  for (const match of best ? moment.matches : []) {
    const [x, y] = placed(best.A_plan_submap, [match.sub_xy[0]], [match.sub_xy[1]]);
    lines[0].push(match.plan_xy[0], x[0], null);
    lines[1].push(match.plan_xy[1], y[0], null);
  }
  return lines;
}

function doorNames(moment, side) {
  const doors = moment.matches.filter((match) => match.is_door);
  const places = doors.map((match) => side === 'plan' ? match.plan_xy : match.sub_xy);
  const names = doors.map((match) =>
    side === 'plan' ? String(match.plan_id) : match.sub_id + '→' + match.plan_id);
  return [places.map((xy) => xy[0]), places.map((xy) => xy[1]), names];
}

function publishedUntil(time) {
  const all = data.published;
  let count = all.time_s.findIndex((t) => t > time);
  if (count < 0) count = all.time_s.length;
  const logs = all.quality_m.slice(0, count).map((m) => m === null ? null : Math.log10(m));
  return [all.x.slice(0, count), all.y.slice(0, count), null, logs];
}

function showPlan(moment) {
  const published = publishedUntil(moment.time_s);
  const columns = {matches: matchLines(moment), published, ellipse: moment.ellipse,
    door_names: doorNames(moment, 'plan')};
  const best = moment.placements[0];
  const isAccepted = moment.A_plan_near !== null;
  const near = moment.near[0].length ? moment.near : moment.walls;
  columns.near = isAccepted ? placed(moment.A_plan_near, ...near) : [[], []];
  // Runners-up would cover an accepted placement; the table lists them.
  const shown = best && best.is_claimed ? [best] : moment.placements;
  data.placement_colours.forEach((_, rank) => {
    const placement = shown[rank];
    columns['placement_' + rank] =
      placement ? placed(placement.A_plan_submap, ...moment.walls) : [[], []];
  });
  const A_plan_robot = isAccepted ? moment.A_plan_near : best && best.A_plan_submap;
  columns.robot = A_plan_robot ? placed(A_plan_robot, ...last(moment.path)) : [[], []];
  update('plan', columns);
  Plotly.restyle('plan', {'marker.color': [published[3]]}, [traceIndex('plan', 'published')]);
  // The whole submap drifts; once localized, the walls of the last metres count.
  Plotly.restyle('plan', {opacity: isAccepted ? FAINT : BEST}, [traceIndex('plan', 'placement_0')]);
  const heading = A_plan_robot && moment.heading !== null ?
    moment.heading + yawOf(A_plan_robot) : null;
  turnRobot('plan', heading, isAccepted);
  let said = 'Floorplan; no placement yet';
  if (columns.robot[0].length) {
    const yaw = heading === null ? '' : `, heading ${degrees(heading).toFixed(0)} degrees`;
    said = `Floorplan; the most likely position of the robot is x ${columns.robot[0][0].toFixed(1)}, ` +
      `y ${columns.robot[1][0].toFixed(1)} metres${yaw}; ${shown.length} placements shown`;
  }
  document.getElementById('plan').setAttribute('aria-label', said);
}

function showSubmap(moment) {
  const labels = [0, 1, 2].map((k) => moment.labels.map((label) => label[k]));
  const columns = {doors: moment.door_lines, path: moment.path, robot: last(moment.path), labels,
    door_names: doorNames(moment, 'submap')};
  for (const key of Object.keys(columns)) columns[key] = turned(moment, columns[key]);
  update('submap', columns);
  turnRobot('submap', moment.heading === null ? null : moment.heading + moment.turn, true);
  document.getElementById('submap').setAttribute('aria-label',
    `Submap of ${moment.rooms} rooms and ${moment.doors} doors, ${moment.matches.length} of them matched`);
  const picture = moment.picture;
  if (!picture) return Plotly.relayout('submap', {images: []});
  return Plotly.relayout('submap', {
    images: [picture],
    'xaxis.range': moment.view[0],
    'yaxis.range': moment.view[1],
  });
}

function row(cells) {
  const element = document.createElement('tr');
  element.append(...cells.map((content) => {
    const cell = document.createElement('td');
    cell.append(content);
    return cell;
  }));
  return element;
}

// The symbol and colour of the placement's walls on the floorplan.
function marked(text, rank) {
  const mark = document.createElement('span');
  mark.className = 'mark';
  mark.textContent = data.placement_signs[rank];
  mark.style.color = data.placement_colours[rank];
  mark.style.background = colour('--paper');
  mark.setAttribute('aria-hidden', 'true');
  const cell = document.createElement('span');
  cell.append(mark, ' ' + text);
  return cell;
}

function badge(element, status) {
  element.className = 'badge';
  element.textContent = status;
  element.style.background = data.status_colours[status];
  element.style.color = data.status_inks[status];
  return element;
}

function showTables(moment) {
  const placements = moment.placements.map((p, rank) => {
    const A = p.A_plan_submap;
    const scale = Math.sqrt(Math.abs(A[0][0] * A[1][1] - A[0][1] * A[1][0]));
    const name = rank ? 'runner-up ' + rank : p.is_claimed ? 'best, accepted' : 'best';
    const values = [p.score.toFixed(3), A[0][2].toFixed(2), A[1][2].toFixed(2),
      degrees(yawOf(A)).toFixed(1), scale.toFixed(3), p.sigma_m === null ? '' : p.sigma_m.toFixed(3)];
    return row([marked(name, rank), ...values]);
  });
  document.querySelector('#placements tbody').replaceChildren(...placements);
  const matches = [...moment.matches].sort((a, b) => b.score - a.score)
    .map((m) => row([m.label, String(m.sub_id), String(m.plan_id), m.score.toFixed(2)]));
  document.querySelector('#matches tbody').replaceChildren(...matches);
  const total = moment.timings_ms.total;
  const facts = [`${moment.rooms} rooms and ${moment.doors} doors in ` +
    `${moment.explored_m2.toFixed(0)} m² of submap`, `${moment.matches.length} matches`];
  if (moment.error_m !== null) facts.push(`error of the best placement ${moment.error_m} m`);
  if (total !== undefined) facts.push(`update took ${total.toFixed(0)} ms`);
  document.getElementById('facts').textContent = facts.join('; ');
}

function showChanges() {
  const rows = data.changes.map((change) => {
    const go = document.createElement('button');
    go.type = 'button';
    go.className = 'link';
    go.textContent = change.time_s.toFixed(1) + ' s';
    go.addEventListener('click', () => goTo(nearest(change.time_s)));
    const line = row([go, badge(document.createElement('span'), change.status),
      change.probability.toFixed(2), change.reason]);
    line.cells[1].className = line.cells[3].className = 'text';
    return line;
  });
  document.querySelector('#changes tbody').replaceChildren(...rows);
}

function show(index) {
  const moment = data.moments[index];
  if (!moment) return;
  slider.value = index;
  const clock = `${moment.time_s.toFixed(1)} s, probability ${moment.probability.toFixed(2)}`;
  document.getElementById('clock').textContent = clock;
  slider.setAttribute('aria-valuetext', `${clock}, ${moment.status}`);
  badge(document.getElementById('status'), moment.status);
  document.getElementById('moment').href = '#t=' + moment.time_s.toFixed(1);
  document.getElementById('reason').textContent = moment.reason;
  showPlan(moment);
  showSubmap(moment);
  showTables(moment);
  Plotly.relayout('timeline', {'shapes[0].x0': moment.time_s, 'shapes[0].x1': moment.time_s});
}

function nearest(time) {
  const gaps = data.moments.map((moment) => Math.abs(moment.time_s - time));
  return gaps.indexOf(Math.min(...gaps));
}

// The time of a link such as report.html#t=12.3; null without one.
function linkedTime() {
  const found = /^#t=(\d+(?:\.\d*)?)$/.exec(location.hash);
  return found ? Number(found[1]) : null;
}

function goTo(index) {
  stop();
  show(index);
}

let timer = null;
function stop() {
  clearInterval(timer);
  timer = null;
  document.getElementById('play').textContent = 'Play';
}

function play() {
  if (timer !== null) return stop();
  if (Number(slider.value) >= data.moments.length - 1) show(0);
  document.getElementById('play').textContent = 'Pause';
  timer = setInterval(() => {
    if (Number(slider.value) >= data.moments.length - 1) return stop();
    show(Number(slider.value) + 1);
  }, FRAME_MS);
}

document.getElementById('play').addEventListener('click', play);
slider.addEventListener('input', () => goTo(Number(slider.value)));
window.addEventListener('hashchange', () => {
  if (linkedTime() !== null) goTo(nearest(linkedTime()));
});
// Buttons, links and folded parts have their own use of the space bar.
document.addEventListener('keydown', (event) => {
  if (event.key !== ' ' || event.target.closest('button, a, summary, .scroll')) return;
  event.preventDefault();
  play();
});

function onTimeline(event) {
  goTo(nearest(event.points[0].x));
}

// A live page receives the run so far when it opens, then one event per update.
function isFollowing() {
  return Number(slider.value) >= data.moments.length - 1 && timer === null;
}

async function showTimeline(figure) {
  if (!figure) return;
  const chart = document.getElementById('timeline');
  const layout = {...figure.layout, margin: chart.layout.margin, dragmode: chart.layout.dragmode};
  await Plotly.react('timeline', figure.data, layout);
  applyTheme();
}

function sayStatus(moment, said) {
  const now = moment ? `${moment.status}, p ${moment.probability.toFixed(2)}` : 'Waiting for the run';
  document.getElementById('answer').textContent = said || now;
}

const told = {
  async run(event) {
    const at = isFollowing() ? Infinity : data.moments[Number(slider.value)].time_s;
    Object.assign(data, event.data);
    slider.max = Math.max(data.moments.length - 1, 0);
    await showTimeline(event.timeline);
    showChanges();
    show(at === Infinity ? data.moments.length - 1 : nearest(at));
    sayStatus(data.moments[data.moments.length - 1], event.said);
  },
  async update(event) {
    const follows = isFollowing();
    data.moments.push(event.moment);
    for (const key of event.published ? Object.keys(event.published) : []) {
      data.published[key].push(...event.published[key]);
    }
    data.changes = event.changes;
    slider.max = data.moments.length - 1;
    await showTimeline(event.timeline);
    showChanges();
    sayStatus(event.moment);
    if (follows) show(data.moments.length - 1);
  },
  async reload() {
    source.close();
    location.reload();
  },
  async end(event) {
    sayStatus(null, event.said);
    source.close();
  },
};

let source = null;
let queued = Promise.resolve();
function listen() {
  source = new EventSource('events');
  source.onmessage = (message) => {
    const event = JSON.parse(message.data);
    queued = queued.then(() => told[event.kind](event));
  };
}

drawAll(['plan', 'submap', 'timeline']).then(() => {
  document.getElementById('timeline').on('plotly_click', onTimeline);
  const {status} = data.summary;
  if (status) document.getElementById('result').style.borderColor = data.status_colours[status];
  showChanges();
  show(linkedTime() === null ? data.moments.length - 1 : nearest(linkedTime()));
  if (data.live) listen();
  document.body.dataset.ready = 'true';
});
