// Which effects look alike in these recordings: a square for each pair.
const imitationSection = ({findings}) => {
  const {effects, shares} = findings.detection.imitation;
  if (effects.length < 2) return;
  const part = section(
      'What looks alike in these recordings',
      'How much of what the effect of a row would do another effect can imitate, once the ship\'s own parameters ' +
          'have done what they can: 0 (white) none, 1 (dark) all of it.');
  const side = Math.max(10, Math.min(24, 620 / effects.length));
  const axis = (options, ticks) => ({
    min: -0.6,
    max: effects.length - 0.4,
    grid: {display: false},
    afterBuildTicks: (scale) => {
      scale.ticks = effects.map((_, i) => ({value: i}));
    },
    ticks: {autoSkip: false, callback: (i) => effects[i], ...ticks},
    ...options,
  });
  const squares = {
    data: shares.flatMap((row, i) => row.map((share, j) => ({x: j, y: i, share}))),
    pointStyle: 'rect',
    radius: side * 0.68,
    hoverRadius: side * 0.68,
    borderWidth: 0,
    backgroundColor: shares.flatMap((row) => row.map((share) => transparent(COLOR.surge, share))),
  };
  const tip = ({raw}) => `${effects[raw.y]} by ${effects[raw.x]}: ${percent(raw.share)}`;
  chart(part, 190 + side * effects.length, 'imitation of effects by effects', {
    type: 'scatter',
    data: {datasets: [squares]},
    options: {
      layout: {padding: {right: 20}},
      scales: {
        x: axis({position: 'top', title: axisTitle('imitated by')}, {minRotation: 60, maxRotation: 60}),
        y: axis({reverse: true}, {}),
      },
      plugins: {tooltip: {callbacks: {label: tip}}},
    },
  });
};
