// Free runs with the ship as it is and with what was missing: errors, and tracks of what was held out.
const MOST_RECORDINGS = 20;

const beforeAfterSection = ({explanation}) => {
  const part = section(
      'Fit before and after',
      'Root mean square errors of free runs from recorded states with the recorded inputs. Held out: ' +
          (explanation.heldout_is_given ? 'recordings that nothing was fitted to.' :
                                          'each part of the recordings with what was fitted to the others.'));
  const {heldout, train} = explanation.fit;
  const lines = [['held out', heldout], ['fitted', train]].flatMap(
      ([name, {before, after}]) =>
          Object.keys(before.free_runs)
              .map((horizon) => ({name, horizon, before: before.free_runs[horizon], after: after.free_runs[horizon]})));
  const both = (key) => ({before, after}) => change(before[key], after[key]);
  part.append(table(
                  [
                    {name: 'Recordings', of: (l) => l.name},
                    {name: 'Run [s]', of: (l) => l.horizon, kind: 'number'},
                    {name: 'u [m/s]', of: both('rmse_u_mps'), kind: 'number'},
                    {name: 'v_m [m/s]', of: both('rmse_vm_mps'), kind: 'number'},
                    {name: 'r [deg/s]', of: both('rmse_r_degps'), kind: 'number'},
                    {name: 'position [m]', of: both('rmse_position_m'), kind: 'number'},
                  ],
                  lines)
                  .node);
  const {before, after} = heldout;
  bars(
      part, 'position error of held-out runs of 100 s by recording, before and after',
      Object.keys(before.recordings)
          .slice(0, MOST_RECORDINGS)
          .flatMap(
              (name) =>
                  [{label: `${name} before`, value: before.recordings[name].rmse_position_m, color: COLOR.grey},
                   {label: 'after', value: after.recordings[name]?.rmse_position_m, color: COLOR.sway},
  ]),
      {axis: 'position error of held-out runs of 100 s [m]', min: 0});
};

// Where a wall, a fixed point or a pull of what was named lies, as lines on a map of a track.
const placesOf = ({hypotheses}, track) => {
  const chosen = hypotheses.find((h) => h.chosen);
  const value = (name) => chosen?.parameters[name]?.estimate;
  const lines = [], known = (...names) => names.every((name) => isKnown(value(name)));
  const east = track.measured_y0_m.filter(isKnown), north = track.measured_x0_m.filter(isKnown);
  const reach = Math.max(...range(east).map(Math.abs), ...range(north).map(Math.abs));
  if (known('wall_distance_m', 'wall_direction_deg')) {
    const angle = value('wall_direction_deg') * Math.PI / 180, distance = value('wall_distance_m');
    const at = (along) => ({
      x: distance * Math.sin(angle) + along * Math.cos(angle),
      y: distance * Math.cos(angle) - along * Math.sin(angle),
    });
    lines.push({label: 'wall', borderColor: COLOR.located, borderWidth: 4, data: [at(-reach), at(reach)]});
  }
  if (known('anchor_x_m', 'anchor_y_m')) {
    const point = {x: value('anchor_y_m'), y: value('anchor_x_m')};
    lines.push({label: 'fixed point', borderColor: COLOR.located, borderWidth: 12, borderCapStyle: 'round', data: [point, point]});
  }
  if (known('t_start_s', 't_end_s'))
    lines.push({
      label: 'pull',
      borderColor: transparent(COLOR.located, 0.5),
      borderWidth: 9,
      data: track.t_s.map((t, i) => (t >= value('t_start_s') && t <= value('t_end_s') ?
                                         {x: track.measured_y0_m[i] ?? NaN, y: track.measured_x0_m[i] ?? NaN} :
                                         {x: NaN, y: NaN})),
    });
  return lines;
};

// Velocities over time and tracks of one recording: what was recorded, and free runs before and after.
const heldoutTracksSection = ({explanation}) => {
  const {tracks} = explanation;
  if (tracks.length === 0) return;
  const pick = choice('recording of the tracks', tracks.map((track) => track.recording));
  const part = section(
      explanation.heldout_is_given ? 'Held-out recordings before and after' : 'What was left out in turn, before and after',
      'Free runs of up to 100 s, one after another from recorded states, with the recorded inputs.', pick);
  const velocities = [['u', 'm/s'], ['v_m', 'm/s'], ['r', 'deg/s']].map(([name, unit]) => velocityChart(part, name, unit));
  const hasTrack = tracks.some(({before}) => before.measured_x0_m.some(isKnown));
  const map = hasTrack ? trackMap(part, 420, 'tracks before and after', {tooltip: {enabled: false}}) : null;
  const line = (label, color, width, norths, easts) => ({
    label,
    borderColor: color,
    borderWidth: width,
    data: norths.map((x, i) => ({x: easts[i] ?? NaN, y: x ?? NaN})),
  });
  const show = ({before, after}) => {
    velocities.forEach((made, axis) => showVelocity(made, before.velocities[axis], after.velocities[axis]));
    if (!map) return;
    const places = placesOf(explanation, before);
    showOn(
        map,
        [
          ...places,
          line('recorded', COLOR.ink, 2, before.measured_x0_m, before.measured_y0_m),
          line('before', COLOR.yaw, 1.5, before.x0_m, before.y0_m),
          line('after', COLOR.sway, 1.5, after.x0_m, after.y0_m),
        ],
        [...before.measured_y0_m, ...before.y0_m, ...after.y0_m],
        [...before.measured_x0_m, ...before.x0_m, ...after.x0_m]);
  };
  pick.addEventListener('change', () => show(tracks[Number(pick.value)]));
  show(tracks[0]);
  const places = placesOf(explanation, tracks[0].before);
  part.append(legend(
      [COLOR.ink, 'recorded'], [COLOR.yaw, 'before'], [COLOR.sway, 'after'],
      ...places.map(({label}) => [COLOR.located, label])));
};

const velocityChart = (part, name, unit) => chart(part, 150, `${name} over time, recorded, before and after`, {
  type: 'line',
  data: {
    datasets: [['recorded', COLOR.ink, 1.6], ['before', COLOR.yaw, 1.2], ['after', COLOR.sway, 1.2]].map(
        ([label, color, width]) => ({label, borderColor: color, borderWidth: width, data: []}))
  },
  options: {
    parsing: false,
    scales: {
      x: {type: 'linear', title: axisTitle(name === 'r' ? 'time [s]' : ''), ticks: {maxTicksLimit: 16, includeBounds: false}},
      y: {title: axisTitle(`${name} [${unit}]`), ticks: {maxTicksLimit: 5}, afterFit(scale) { scale.width = 74; }},
    },
    plugins: {tooltip: {enabled: false}},
  },
});

const showVelocity = (made, before, after) => {
  const points = ({t_s: t}, values) => t.map((x, i) => ({x: x ?? NaN, y: values[i] ?? NaN}));
  const [recorded, first, second] = made.data.datasets;
  recorded.data = points(before, before.measured);
  first.data = points(before, before.run);
  second.data = points(after, after.run);
  const [start, end] = range(before.t_s);
  made.options.scales.x.min = start;
  made.options.scales.x.max = end;
  made.update('none');
};
