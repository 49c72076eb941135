const data = JSON.parse(document.getElementById('data').textContent);
const slider = document.getElementById('slider');
const MATCHES_SHOWN = 12;
const FRAME_MS = 250;

function traceIndex(name, key) {
  return document.getElementById(name).data.findIndex((trace) => trace.meta === key);
}

function placed(A, xs, ys) {
  return [
    xs.map((x, i) => A[0][0] * x + A[0][1] * ys[i] + A[0][2]),
    xs.map((x, i) => A[1][0] * x + A[1][1] * ys[i] + A[1][2]),
  ];
}

function update(name, columns) {
  const keys = Object.keys(columns);
  const change = {x: keys.map((key) => columns[key][0]), y: keys.map((key) => columns[key][1])};
  if (name === 'submap') change.text = keys.map((key) => columns[key][2] || null);
  return Plotly.restyle(name, change, keys.map((key) => traceIndex(name, key)));
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

function publishedUntil(time) {
  const all = data.published;
  let count = all.time_s.findIndex((t) => t > time);
  if (count < 0) count = all.time_s.length;
  return [all.x.slice(0, count), all.y.slice(0, count)];
}

function showPlan(moment) {
  const columns = {matches: matchLines(moment), published: publishedUntil(moment.time_s)};
  data.placement_colours.forEach((_, rank) => {
    const placement = moment.placements[rank];
    columns['placement_' + rank] =
      placement ? placed(placement.A_plan_submap, ...moment.walls) : [[], []];
  });
  const best = moment.placements[0];
  columns.robot = best ? placed(best.A_plan_submap, ...last(moment.path)) : [[], []];
  return update('plan', columns);
}

function showSubmap(moment) {
  const labels = moment.labels;
  update('submap', {
    doors: moment.door_lines,
    path: moment.path,
    robot: last(moment.path),
    labels: [labels.map((l) => l[0]), labels.map((l) => l[1]), labels.map((l) => l[2])],
  });
  const picture = moment.picture;
  if (!picture) return Plotly.relayout('submap', {images: []});
  return Plotly.relayout('submap', {
    images: [picture],
    'xaxis.range': [picture.x, picture.x + picture.sizex],
    'yaxis.range': [picture.y - picture.sizey, picture.y],
  });
}

function row(cells, colour) {
  const element = document.createElement('tr');
  cells.forEach((text, index) => {
    const cell = element.insertCell();
    if (index === 0 && colour) {
      const swatch = cell.appendChild(document.createElement('span'));
      swatch.className = 'swatch';
      swatch.style.background = colour;
    }
    cell.append(text);
  });
  return element;
}

function showTables(moment) {
  const placements = moment.placements.map((p, rank) => {
    const A = p.A_plan_submap;
    const yaw = Math.atan2(A[1][0], A[0][0]) * 180 / Math.PI;
    const scale = Math.sqrt(Math.abs(A[0][0] * A[1][1] - A[0][1] * A[1][0]));
    const name = rank ? 'rival ' + rank : p.is_claimed ? 'best, claimed' : 'best';
    const values = [p.score.toFixed(3), A[0][2].toFixed(2), A[1][2].toFixed(2), yaw.toFixed(1),
      scale.toFixed(3), p.sigma_m === null ? '' : p.sigma_m.toFixed(3)];
    return row([name, ...values], data.placement_colours[rank]);
  });
  document.querySelector('#placements tbody').replaceChildren(...placements);
  const matches = [...moment.matches].sort((a, b) => b.score - a.score).slice(0, MATCHES_SHOWN)
    .map((m) => row([m.label, String(m.plan_id), String(m.sub_id), m.score.toFixed(2)]));
  document.querySelector('#matches tbody').replaceChildren(...matches);
  const total = moment.timings_ms.total;
  const facts = [`${moment.rooms} rooms and ${moment.doors} doors in ` +
    `${moment.explored_m2.toFixed(0)} m² of submap`, `${moment.matches.length} matches`];
  if (moment.error_m !== null) facts.push(`best placement off by ${moment.error_m} m`);
  if (total !== undefined) facts.push(`tick took ${total.toFixed(0)} ms`);
  document.getElementById('facts').textContent = facts.join('; ');
}

function show(index) {
  const moment = data.moments[index];
  if (!moment) return;
  slider.value = index;
  document.getElementById('clock').textContent =
    `${moment.time_s.toFixed(1)} s, probability ${moment.probability.toFixed(2)}`;
  const badge = document.getElementById('status');
  badge.textContent = moment.status;
  badge.style.background = data.status_colours[moment.status];
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

let timer = null;
function stop() {
  clearInterval(timer);
  timer = null;
  document.getElementById('play').textContent = 'Play';
}

document.getElementById('play').addEventListener('click', () => {
  if (timer !== null) return stop();
  if (Number(slider.value) >= data.moments.length - 1) show(0);
  document.getElementById('play').textContent = 'Pause';
  timer = setInterval(() => {
    if (Number(slider.value) >= data.moments.length - 1) return stop();
    show(Number(slider.value) + 1);
  }, FRAME_MS);
});
slider.addEventListener('input', () => { stop(); show(Number(slider.value)); });

Promise.all(['plan', 'submap', 'timeline'].map(draw)).then(() => {
  document.getElementById('timeline').on('plotly_click', (event) => {
    stop();
    show(nearest(event.points[0].x));
  });
  show(data.moments.length - 1);
  document.body.dataset.ready = 'true';
});
