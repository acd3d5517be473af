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

const heldoutTracksSection = ({explanation: {tracks}}) => {
  if (tracks.length === 0) return;
  const pick = choice('recording of the tracks', tracks.map((track) => track.recording));
  const part = section(
      'Held-out tracks before and after',
      'Free runs of 100 s, one after another from recorded states, with the recorded inputs.', pick);
  const map = trackMap(part, 420, 'tracks before and after', {tooltip: {enabled: false}});
  const line = (label, color, width, norths, easts) => ({
    label,
    borderColor: color,
    borderWidth: width,
    data: norths.map((x, i) => ({x: easts[i] ?? NaN, y: x ?? NaN})),
  });
  const show = ({before, after}) => showOn(
      map,
      [
        line('recorded', COLOR.ink, 2, before.measured_x0_m, before.measured_y0_m),
        line('before', COLOR.yaw, 1.5, before.x0_m, before.y0_m),
        line('after', COLOR.sway, 1.5, after.x0_m, after.y0_m),
      ],
      [...before.measured_y0_m, ...before.y0_m, ...after.y0_m],
      [...before.measured_x0_m, ...before.x0_m, ...after.x0_m]);
  pick.addEventListener('change', () => show(tracks[Number(pick.value)]));
  show(tracks[0]);
  part.append(legend([COLOR.ink, 'recorded'], [COLOR.yaw, 'before'], [COLOR.sway, 'after']));
};
