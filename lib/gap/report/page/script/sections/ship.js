// Where on the ship: the share of each axis, and where the side force acts.
const shipSection = ({findings: {located}}) => {
  const axes = AXES.filter((axis) => isKnown(located.dof[axis])), line = located.line_of_action;
  const hasShares = axes.some((axis) => located.dof[axis] > 0), hasLine = line && isKnown(line.x_F_over_L_pp);
  if (!hasShares && !hasLine) return;
  const boxes = grid(section('Where it acts on the ship'), hasShares && line ? 'two' : '');
  if (hasShares)
    bars(
        boxIn(boxes, 'Direction: share of what is missing'), 'share of each axis',
        axes.map(
            (axis) =>
                ({label: axis, value: 100 * located.dof[axis], color: COLOR[axis], tip: percent(located.dof[axis])})),
        {min: 0, max: 100, tickText: percentTick});
  if (hasLine) lineOfAction(boxes, line);
};

// The outline of a ship of beam L/6 from above, its bow to the right.
const STARBOARD = [[-0.5, 0.06], [-0.46, 0.075], [-0.35, 0.083], [0.25, 0.083], [0.36, 0.074], [0.44, 0.05], [0.5, 0]];
const OUTLINE = [...STARBOARD, ...STARBOARD.slice(0, -1).reverse().map(([x, y]) => [x, -y]), STARBOARD[0]];

const lineOfAction = (parent, {x_F_over_L_pp: x, x_F_over_L_pp_sd, x_F_m}) => {
  const sd = x_F_over_L_pp_sd ?? 0;
  const reach = Math.max(0.65, Math.min(3, Math.abs(x) + 2 * sd + 0.1));
  const at = Math.max(-reach, Math.min(reach, x));
  const box = boxIn(
      parent,
      `Where the side force acts: ${withSd(Math.abs(x), sd)} ship lengths ${sideOf(x)} of midship` +
          (isKnown(x_F_m) ? ` (${short(Math.abs(x_F_m))} m)` : ''));
  const force = {
    data: [{x: at, y: 0}],
    pointRadius: 7,
    pointBackgroundColor: COLOR.sway,
    pointBorderColor: '#fff',
    errors: 'x',
    center: [at],
    sd: [2 * sd]
  };
  const hull = {
    data: OUTLINE.map(([along, across]) => ({x: along, y: across})),
    borderColor: '#8c98a4',
    backgroundColor: '#eef2f5',
    fill: 'shape',
    tension: 0
  };
  const ends = `stern ${fixed(-0.5, 1)}, midship 0, bow ${fixed(0.5, 1)}`;
  chart(box, 132, 'line of action along the ship', {
    type: 'line',
    data: {datasets: [force, hull]},
    options: {
      parsing: false,
      scales: {
        x: {
          type: 'linear',
          min: -reach,
          max: reach,
          title: axisTitle(`position in ship lengths; ${ends} (bar: two standard deviations)`),
          ticks: {callback: (v) => short(v, 2), includeBounds: false}
        },
        y: {min: -0.13, max: 0.13, display: false},
      },
      plugins: {
        tooltip: {
          filter: (item) => item.datasetIndex === 0,
          callbacks: {title: () => '', label: () => shipLengths(x, sd)},
        },
      },
    },
  });
};
