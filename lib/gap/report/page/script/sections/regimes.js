// What the residual goes with: bins of each variable that holds.
const MOST_REGIMES = 9;

const regimesSection = ({findings: {located: {regime: regimes}}}) => {
  if (regimes.length === 0) return;
  const part = section(
      'What it goes with',
      'Mean residual acceleration in bins of one variable, with two standard errors.' +
          ' Listed is what holds after correction for the number of variables tried.');
  const boxes = grid(part, 'three');
  const plotted = regimes.filter((regime) => regime.x.length > 0).slice(0, MOST_REGIMES);
  for (const regime of plotted) regimeBox(boxes, regime);
  const others = regimes.filter((regime) => !plotted.includes(regime));
  if (others.length > 0)
    part.append(list(others.map((regime) => `${regime.sentence} (${regime.dof}, p ${pValue(regime.p_value)})`)));
};

const regimeBox = (parent, regime) => {
  const box = boxIn(parent, regime.sentence);
  regimeChart(box, regime);
  box.append(element(
      'div', {class: 'note'},
      `${regime.relation}, p ${pValue(regime.p_value)}, ${percent(regime.share)} of the ${regime.dof} residual`));
};

const regimeChart = (box, regime) => {
  const axis = regime.dof, {key, scale, unit} = ACCELERATION[axis];
  const means = regime['mean_' + key], sds = regime['mean_sd_' + key];
  const rows = regime.x.map((x, i) => ({x, y: isKnown(means[i]) ? scale * means[i] : NaN, sd: 2 * scale * sds[i]}))
                   .filter((row) => isKnown(row.x) && isKnown(row.y));
  const ends = rows.flatMap((row) => [row.y - row.sd, row.y + row.sd]);
  const bins = {
    data: rows,
    borderColor: transparent(COLOR[axis], 0.6),
    pointRadius: 4,
    pointBackgroundColor: COLOR[axis],
    pointBorderColor: '#fff',
    errors: 'y',
    errorColor: COLOR[axis],
    center: rows.map((row) => row.y),
    sd: rows.map((row) => row.sd)
  };
  const tip = ({raw}) => `${short(raw.y)}${PLUS_MINUS}${short(raw.sd / 2, 2)} ${unit} at ${short(raw.x)}`;
  chart(box, 210, regime.sentence, {
    type: 'line',
    data: {datasets: [bins]},
    options: {
      parsing: false,
      scales: {
        x: {type: 'linear', title: axisTitle(regime.x_label || regime.variable), ticks: {maxTicksLimit: 7}},
        y: {
          title: axisTitle(`${axis} [${unit}]`),
          suggestedMin: Math.min(0, ...ends),
          suggestedMax: Math.max(0, ...ends),
          ticks: {maxTicksLimit: 6}
        },
      },
      plugins: {
        marks: {axis: 'y', values: [0], color: COLOR.zero},
        tooltip: {callbacks: {title: () => '', label: tip}},
      },
    },
  });
};

// In place of intervals and regimes where there are none.
const nothingLocatedSection = ({findings: {located, verdict}}) => {
  if (located.intervals.length > 0 || located.regime.length > 0) return;
  const texts = {
    mismatch: 'No interval and no variable stands out: the residual is spread over the recordings.',
    'no-mismatch': 'Nothing to locate: no interval, no frame and no variable stands out from noise.',
    undecided: 'Nothing could be located.'
  };
  section('Location').append(paragraph(texts[verdict]));
};
