// What Chart.js does not draw by itself. Each plugin takes its options from options.plugins[id] of a chart.
const countDrawn = {
  id: 'countDrawn',
  afterRender(chart) { chart.canvas.dataset.drawn = 'yes'; },
};

// Vertical bands behind the lines: {list: () => [{from, to, color}]}.
const bands = {
  id: 'bands',
  beforeDatasetsDraw(chart, _, options) {
    const {ctx, chartArea: area, scales: {x}} = chart;
    for (const {from, to, color} of options.list ? options.list() : []) {
      const left = Math.max(area.left, Math.min(area.right, x.getPixelForValue(from)));
      const right = Math.max(area.left, Math.min(area.right, x.getPixelForValue(to)));
      ctx.save();
      ctx.fillStyle = color;
      ctx.fillRect(left, area.top, Math.max(right - left, 2), area.bottom - area.top);
      ctx.restore();
    }
  },
};

// Lines from one point to another, as one path.
const stroke = (ctx, ...lines) => {
  ctx.beginPath();
  for (const [from, to] of lines) {
    ctx.moveTo(...from);
    ctx.lineTo(...to);
  }
  ctx.stroke();
};

// Dashed lines across the chart at values of one axis: {axis, values, color}.
const marks = {
  id: 'marks',
  afterDatasetsDraw(chart, _, {axis, values, color}) {
    if (!values) return;
    const {ctx, chartArea: area, scales} = chart;
    ctx.save();
    ctx.strokeStyle = color || COLOR.soft;
    ctx.setLineDash([5, 4]);
    for (const value of values) {
      const at = scales[axis].getPixelForValue(value);
      if (axis === 'x')
        stroke(ctx, [[at, area.top], [at, area.bottom]]);
      else
        stroke(ctx, [[area.left, at], [area.right, at]]);
    }
    ctx.restore();
  },
};

// Error bars: a data set with `errors: "x"` or `"y"` has `center` and `sd` of its points.
const errorBars = {
  id: 'errorBars',
  afterDatasetsDraw(chart) {
    chart.data.datasets.forEach((set, index) => {
      if (!set.errors) return;
      const {ctx, scales} = chart, scale = scales[set.errors], alongX = set.errors === 'x';
      ctx.save();
      ctx.strokeStyle = set.errorColor || COLOR.ink;
      ctx.lineWidth = 1.2;
      chart.getDatasetMeta(index).data.forEach((point, i) => {
        const sd = set.sd[i];
        if (!isKnown(sd) || sd <= 0) return;
        const at = (along, across) => (alongX ? [along, point.y + across] : [point.x + across, along]);
        const ends = [set.center[i] - sd, set.center[i] + sd].map((value) => scale.getPixelForValue(value));
        stroke(ctx, [at(ends[0], 0), at(ends[1], 0)], ...ends.map((end) => [at(end, -3), at(end, 3)]));
      });
      ctx.restore();
    });
  },
};

// One meter is as long to the north as to the east: the range of the wider axis grows into the room that is left.
// {extent: {x: [low, high], y: [low, high]}}
const equalScales = {
  id: 'equalScales',
  afterLayout(chart, _, {extent}) {
    if (!extent) return;
    const {chartArea: area, scales: {x, y}} = chart;
    const width = area.right - area.left, height = area.bottom - area.top;
    if (width <= 0 || height <= 0) return;
    const perPixel = 1.06 * Math.max((extent.x[1] - extent.x[0]) / width, (extent.y[1] - extent.y[0]) / height, 1e-9);
    for (const [scale, pixels, [low, high]] of [[x, width, extent.x], [y, height, extent.y]]) {
      const middle = (low + high) / 2, min = middle - (perPixel * pixels) / 2, max = middle + (perPixel * pixels) / 2;
      const now = chart.options.scales[scale.id];
      if (Math.abs((now.min ?? 0) - min) + Math.abs((now.max ?? 0) - max) < 0.01 * (max - min)) continue;
      now.min = min;
      now.max = max;
      chart.redo = true;
    }
  },
  afterRender(chart) {
    if (!chart.redo || chart.redone > 3) return;
    chart.redo = false;
    chart.redone = (chart.redone || 0) + 1;
    chart.update('none');
  },
  resize(chart) { chart.redone = 0; },
};

Chart.register(countDrawn, bands, marks, errorBars, equalScales);
