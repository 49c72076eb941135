'use strict';
const config = {
  responsive: true,
  displaylogo: false,
  scrollZoom: true,
  modeBarButtonsToRemove: ['select2d', 'lasso2d', 'autoScale2d'],
};
function draw(name) {
  const figure = JSON.parse(document.getElementById('figure-' + name).textContent);
  return Plotly.newPlot(name, figure.data, figure.layout, config);
}
