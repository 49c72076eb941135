'use strict';
const isNarrow = window.matchMedia('(max-width: 600px)');
const isDark = window.matchMedia('(prefers-color-scheme: dark)');
const PRINTED_PX = 650;
const PRINTED_FONT_PX = 8;
const PRINTED_HIGH_PX = {map: 390, other: 230};
const FONT_PX = 12;
const charts = [];
const legends = {};
let figures = {};
let data = {};

async function unpacked(id) {
  const packed = atob(document.getElementById(id).textContent);
  const bytes = Uint8Array.from(packed, (character) => character.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('gzip'));
  return new Response(stream).text();
}

async function unpack() {
  const [library, content] = await Promise.all(['plotly', 'content'].map(unpacked));
  const script = document.createElement('script');
  script.textContent = library;
  document.head.append(script);
  ({figures, data} = JSON.parse(content));
}

function colour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

// Axes and their texts follow the theme of the page; maps keep the colours of paper.
function themed(layout) {
  const ink = colour('--ink');
  const change = {
    'paper_bgcolor': 'rgba(0,0,0,0)', 'font.color': ink, 'modebar.color': ink,
    'modebar.activecolor': colour('--accent'), 'modebar.bgcolor': 'rgba(0,0,0,0)',
    'plot_bgcolor': layout.meta === 'map' ? colour('--paper') : 'rgba(0,0,0,0)',
    'hoverlabel.bgcolor': colour('--card'), 'hoverlabel.font.color': ink,
  };
  for (const axis of Object.keys(layout).filter((key) => /^[xy]axis/.test(key))) {
    change[axis + '.gridcolor'] = colour('--line');
    change[axis + '.zerolinecolor'] = colour('--line');
    change[axis + '.linecolor'] = colour('--line');
  }
  if (layout.meta !== 'map') change['shapes[0].line.color'] = ink;
  return change;
}

function applyTheme() {
  for (const name of charts) {
    const chart = document.getElementById(name);
    Plotly.relayout(name, themed(chart.layout));
    const inked = chart.data.flatMap((trace, k) => trace.meta === 'ink' ? [k] : []);
    if (inked.length) Plotly.restyle(name, {'line.color': colour('--ink')}, inked);
  }
}

// Scrolling on a touch screen must not pan a chart; its buttons zoom.
async function draw(name) {
  const {data: traces, layout} = figures[name];
  if (isNarrow.matches) {
    layout.dragmode = false;
    layout.margin = {...layout.margin, l: 44, r: 6};
    if (layout.legend) layout.legend.y *= 2;
    // Two columns: a dozen entries in one column leave no room for the floorplan.
    if (layout.legend && layout.meta === 'map') {
      Object.assign(layout.legend, {
        entrywidth: 0.5, entrywidthmode: 'fraction', font: {size: 10},
      });
    }
  }
  await Plotly.newPlot(name, traces, layout, {
    responsive: true,
    displaylogo: false,
    scrollZoom: !isNarrow.matches,
    modeBarButtonsToRemove: ['select2d', 'lasso2d', 'autoScale2d'],
  });
  charts.push(name);
  legends[name] = document.getElementById(name).layout.showlegend;
}

async function drawAll(names) {
  try {
    await unpack();
  } catch (error) {
    const trouble = document.getElementById('trouble');
    trouble.textContent = 'This browser cannot unpack the page (' + error.message + '): ' +
      'open it with Chrome or Edge 80, Firefox 113, Safari 16.4, or newer.';
    trouble.hidden = false;
    throw error;
  }
  await Promise.all(names.map(draw));
  applyTheme();
  isDark.addEventListener('change', applyTheme);
  window.addEventListener('beforeprint', () => printed(true));
  window.addEventListener('afterprint', () => printed(false));
}

// Print in light colours, at the width of a page.
function printed(isPrint) {
  document.documentElement.classList.toggle('print', isPrint);
  applyTheme();
  for (const name of charts) {
    const chart = document.getElementById(name);
    const high = PRINTED_HIGH_PX[chart.layout.meta] || PRINTED_HIGH_PX.other;
    const size = isPrint ? {width: PRINTED_PX, height: high, autosize: false} :
      {width: null, height: null, autosize: true};
    Plotly.relayout(name, {...size, 'font.size': isPrint ? PRINTED_FONT_PX : FONT_PX,
      showlegend: isPrint ? chart.layout.meta !== 'map' : legends[name]});
  }
}
