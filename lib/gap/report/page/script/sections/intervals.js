// The located intervals as a table, and the track of the shown recording. Returns what shows a recording.
const MOST_INTERVALS = 40;

const intervalsSection = (report, drawn, intervalsOf, withTrack, onPick) => {
  const {intervals} = report.findings.located, located = intervals.length > 0;
  const part = section(
      located ? 'Located intervals' : 'Track',
      located ? 'Stretches where the residual is too large and too steady for chance; the probability' +
              ' holds for all stretches of all recordings together.' :
                '');
  const boxes = grid(part, located && withTrack ? 'wide-narrow' : '');
  if (located) boxes.append(intervalsTable(report.findings, drawn, onPick));
  return withTrack ? locatedTrack(boxes, located, intervalsOf) : () => {};
};

const intervalsTable = ({located, ensemble}, drawn, onPick) => {
  const shown = located.intervals.slice(0, MOST_INTERVALS);
  const columns = [
    {name: 'Recording', of: (i) => i.recording, kind: 'name'},
    {name: 'Time [s]', of: (i) => timeSpan(i.t_start_s, i.t_end_s), kind: 'number'},
    {name: 'Axis', of: (i) => i.dof},
    {name: 'Mean', of: (i) => acceleration(i.mean_acceleration, i.dof), kind: 'number'},
    {name: 'p', of: (i) => pValue(i.p_value), kind: 'number'},
  ];
  if (ensemble)
    columns.push(
        {name: 'Beyond the training data', of: (i) => percent(i.training.outside_share), kind: 'number'},
        {name: 'Mean / members\' sd', of: (i) => short(i.training.mismatch_by_members_sd, 2), kind: 'number'},
        {name: 'Cause', of: (i) => orNotKnown(i.cause)});
  const {node, lines} = table(columns, shown);
  shown.forEach((interval, row) => {
    const at = drawn.findIndex((r) => r.recording === interval.recording && r.file === interval.file);
    if (at < 0 || drawn.length < 2) return;
    lines[row].classList.add('pick');
    lines[row].title = 'show this recording';
    lines[row].addEventListener('click', () => onPick(at));
  });
  node.classList.add('long');
  if (located.intervals.length > shown.length)
    node.append(paragraph(`${count(located.intervals.length - shown.length)} more that are not drawn`, 'note'));
  return node;
};

const locatedTrack = (parent, located, intervalsOf) => {
  const box = boxIn(parent);
  const map = trackMap(box, 380, 'track with the located intervals', {
    interaction: {mode: 'nearest', axis: 'xy', intersect: false},
    tooltip: {callbacks: {title: () => '', label: (item) => atTime(item.raw.t)}},
  });
  box.append(legend([COLOR.grey, 'track'], ...(located ? [[COLOR.located, 'located']] : []), [COLOR.surge, 'start']));
  return (recording) => {
    const {track} = recording;
    box.style.display = track ? '' : 'none';
    if (!track) return;
    const points =
        track.t_s.map((t, i) => ({x: track.y0_m[i] ?? NaN, y: track.x0_m[i] ?? NaN, t})).filter((p) => isKnown(p.t));
    const intervals = intervalsOf(recording);
    const isInside = (p) => intervals.some((i) => p.t >= i.t_start_s && p.t <= i.t_end_s);
    const start = points.find((p) => isKnown(p.x) && isKnown(p.y));
    showOn(
        map,
        [
          {data: start ? [start] : [], pointRadius: 6, pointBackgroundColor: COLOR.surge, pointBorderColor: '#fff'},
          {
            data: points.map((p) => (isInside(p) ? p : {...p, x: NaN, y: NaN})),
            borderColor: COLOR.located,
            borderWidth: 5
          },
          {data: points, borderColor: COLOR.grey, borderWidth: 1.5},
        ],
        points.map((p) => p.x), points.map((p) => p.y));
  };
};
