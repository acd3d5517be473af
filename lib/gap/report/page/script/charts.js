// What the charts of all sections have in common.

// Okabe and Ito's colors, which any color vision distinguishes, and the grays of page.css.
const COLOR = {
  surge: '#0072b2',
  sway: '#009e73',
  yaw: '#d55e00',
  located: '#e69f00',
  ink: '#1c2733',
  soft: '#5b6876',
  grey: '#7b8794',
  zero: '#9aa5b1',
  pale: '#b9c4ce',
};
const transparent = (color, alpha) => color + Math.round(255 * alpha).toString(16).padStart(2, '0');

Chart.defaults.animation = false;
Chart.defaults.font.family = getComputedStyle(document.body).fontFamily;
Chart.defaults.font.size = 12;
Chart.defaults.color = COLOR.soft;
Chart.defaults.maintainAspectRatio = false;
Chart.defaults.plugins.legend.display = false;
Chart.defaults.elements.point.radius = 0;
Chart.defaults.elements.line.borderWidth = 1.4;
Chart.defaults.scale.grid.color = '#edf0f3';
Chart.defaults.scale.grid.borderColor = '#c6ced6';
Chart.defaults.scale.ticks.maxRotation = 0;

const charts = [];
const chart = (parent, height, label, config) => {
  const canvas = element('canvas');
  canvas.setAttribute('role', 'img');
  canvas.setAttribute('aria-label', label);
  parent.append(element('div', {class: 'plot', style: {height: height + 'px'}}, canvas));
  const made = new Chart(canvas, config);
  charts.push(made);
  return made;
};

const axisTitle = (text) => ({display: !!text, text});
const range = (values) =>
    values.filter(isKnown).reduce(([low, high], v) => [Math.min(low, v), Math.max(high, v)], [Infinity, -Infinity]);

// Horizontal bars: rows of {label, value, sd, color, tip}; with {low, high} in place of sd, the bar is that interval.
const bars = (parent, label, rows, {axis, markValues, min, max, tickText} = {}) => {
  const ends = rows.flatMap((row) => [row.low ?? row.value - (row.sd ?? 0), row.high ?? row.value + (row.sd ?? 0)])
                   .filter(isKnown);
  const data = {
    data: rows.map((row) => (isKnown(row.low) ? [row.low, row.high] : row.value)),
    backgroundColor: rows.map((row) => row.color || COLOR.grey),
    maxBarThickness: 18,
    errors: rows.some((row) => isKnown(row.sd)) ? 'x' : undefined,
    center: rows.map((row) => row.value),
    sd: rows.map((row) => row.sd),
  };
  const x = {
    title: axisTitle(axis),
    suggestedMin: Math.min(min ?? 0, ...ends),
    suggestedMax: Math.max(max ?? 0, ...ends),
    ticks: {callback: tickText || tick},
  };
  chart(parent, 44 + 26 * rows.length + (axis ? 18 : 0), label, {
    type: 'bar',
    data: {labels: rows.map((row) => row.label), datasets: [data]},
    options: {
      indexAxis: 'y',
      scales: {x, y: {grid: {display: false}, ticks: {autoSkip: false, color: COLOR.ink}}},
      plugins: {
        marks: {axis: 'x', values: markValues, color: COLOR.ink},
        tooltip: {callbacks: {label: (item) => rows[item.dataIndex].tip || short(rows[item.dataIndex].value)}},
      },
    },
  });
};

// A map of tracks with the same scale to the north and to the east; showOn() puts lines on it.
const trackMap = (parent, height, label, {tooltip, interaction}) => {
  const axis = (text) =>
      ({type: 'linear', title: axisTitle(text), ticks: {callback: positionTick, includeBounds: false}});
  return chart(parent, height, label, {
    type: 'line',
    data: {datasets: []},
    options: {
      parsing: false,
      ...(interaction ? {interaction} : {}),
      scales: {x: axis('y0 [m], east'), y: axis('x0 [m], north')},
      plugins: {equalScales: {}, tooltip},
    },
  });
};
// The map is as high as the tracks need at its width. Tracks that are longer to the north than to the east lie along the
// page: north to the right, east down.
const showOn = (map, datasets, easts, norths) => {
  const [east, north] = [range(easts), range(norths)], length = ([low, high]) => high - low;
  const turned = length(north) > 1.3 * length(east);
  map.data.datasets = turned ?
      datasets.map((set) => ({...set, data: set.data.map(({x, y}) => ({x: y, y: x}))})) :
      datasets;
  const {scales} = map.options, titles = ['y0 [m], east', 'x0 [m], north'];
  [scales.x.title.text, scales.y.title.text] = turned ? [titles[1] + ' (to the right)', titles[0] + ' (down)'] : titles;
  scales.y.reverse = turned;
  const [x, y] = turned ? [north, east] : [east, north];
  map.options.plugins.equalScales = {extent: {x, y}};
  const frame = map.canvas.parentNode, high = frame.clientWidth * length(y) / Math.max(length(x), 1e-9);
  frame.style.height = Math.min(640, Math.max(220, high)) + 'px';
  map.resize();
  map.redone = 0;
  map.update('none');
};
