// When: the residual acceleration over time, one chart for each axis. Returns what shows a recording.
const residualsSection = ({findings: {located}, explanation}, drawn, intervalsOf, pick) => {
  const part = section(
      'When: residual acceleration',
      'What has to be added to the simulator\'s acceleration, with a band of two standard deviations. Where the band' +
          ' leaves zero out, the simulator alone does not explain the recording.',
      pick);
  const view = {recording: drawn[0], intervalsOf};
  const scales = residualScales(drawn);
  const plots = AXES.map((axis) => residualChart(part, axis, scales[axis], view));
  part.append(residualsLegend(located, explanation));
  return (recording) => {
    view.recording = recording;
    const after =
        explanation?.residuals_after.find((r) => r.recording === recording.recording && r.file === recording.file);
    const ends = recording.lines.flatMap((line) => [line.t_s[0], line.t_s[line.t_s.length - 1]]).filter(isKnown);
    AXES.forEach((axis, a) => {
      const datasets = plots[a].data.datasets, {scale} = scales[axis];
      showResidual(datasets, recording.lines[a], scale, recording.thinned);
      datasets[3].data = after ? scaledPoints(after.lines[a], scale) : [];
      plots[a].options.scales.x.min = Math.min(...ends);
      plots[a].options.scales.x.max = Math.max(...ends);
      plots[a].update('none');
    });
  };
};

// As everywhere, but for yaw in thousandths where all of it is small.
const residualScales = (drawn) => {
  const {surge, sway, yaw} = ACCELERATION;
  let largest = 0;
  for (const recording of drawn)
    for (const value of recording.lines[2].value) largest = Math.max(largest, Math.abs(value ?? 0));
  return {surge, sway, yaw: largest < 0.1 ? {scale: 1e3 * yaw.scale, unit: TEN_TO_MINUS_3 + yaw.unit} : yaw};
};

const residualChart = (part, axis, {unit}, view) => {
  const isLast = axis === AXES[AXES.length - 1];
  const shade = (interval) => ({
    from: interval.t_start_s,
    to: interval.t_end_s,
    color: transparent(isUntrained(interval) ? COLOR.grey : COLOR.located, interval.dof === axis ? 0.34 : 0.13)
  });
  return chart(part, isLast ? 190 : 168, `residual ${axis} acceleration over time`, {
    type: 'line',
    data: {
      datasets: [
        {label: 'high', borderWidth: 0, backgroundColor: transparent(COLOR[axis], 0.2), fill: '+1', data: []},
        {label: 'low', borderWidth: 0, fill: false, data: []},
        {label: axis, borderColor: COLOR[axis], data: []},
        {label: 'with what was missing', borderColor: COLOR.ink, borderWidth: 1, data: []},
      ]
    },
    options: {
      parsing: false,
      normalized: true,
      layout: {padding: {right: 18}},
      interaction: {mode: 'nearest', axis: 'x', intersect: false},
      scales: {
        x: {
          type: 'linear',
          title: axisTitle(isLast ? 'time [s]' : ''),
          ticks: {display: isLast, maxTicksLimit: 16, includeBounds: false}
        },
        y: {
          title: axisTitle(`${axis} [${unit}]`),
          ticks: {maxTicksLimit: 6},
          afterFit(scale) { scale.width = 74; },
        },
      },
      plugins: {
        bands: {list: () => view.intervalsOf(view.recording).map(shade)},
        marks: {axis: 'y', values: [0], color: COLOR.zero},
        tooltip: {
          filter: (item) => item.datasetIndex === 2,
          callbacks: {
            title: (items) => (items.length > 0 ? atTime(items[0].parsed.x) : ''),
            label: (item) => `${axis} ${short(item.parsed.y)} ${unit}`,
          },
        },
      },
    },
  });
};

const scaledPoints = ({t_s: t, value}, scale) => t.map((x, i) => ({x, y: isKnown(value[i]) ? scale * value[i] : NaN}));

// The line and its band. Between the points of a thinned line are others: there the band spans that of both neighbors.
const showResidual = (datasets, line, scale, thinned) => {
  const {t_s: t, value, sd} = line, reach = thinned ? 1 : 0;
  const edge = (side, outermost) => t.map((x, i) => {
    const near = [];
    for (let k = Math.max(0, i - reach); k <= Math.min(t.length - 1, i + reach); ++k)
      if (isKnown(value[k]) && isKnown(sd[k])) near.push(scale * (value[k] + side * 2 * sd[k]));
    return {x, y: isKnown(value[i]) && near.length > 0 ? outermost(...near) : NaN};
  });
  datasets[0].data = edge(1, Math.max);
  datasets[1].data = edge(-1, Math.min);
  datasets[2].data = scaledPoints(line, scale);
  datasets[2].borderWidth = thinned ? 0.8 : 1.4;
};

const residualsLegend = ({intervals}, explanation) => {
  const entries = [];
  if (intervals.length > 0)
    entries.push(
        [transparent(COLOR.located, 0.5), 'located interval, on the axis where it shows most'],
        [transparent(COLOR.located, 0.2), 'the same interval on the other axes']);
  if (intervals.some(isUntrained))
    entries.push([transparent(COLOR.grey, 0.5), 'for which the ensemble was not trained']);
  entries.push([transparent(COLOR.grey, 0.35), 'two standard deviations']);
  if (explanation?.residuals_after.length > 0) entries.push([COLOR.ink, 'with what was missing']);
  return legend(...entries);
};
