// What is missing, by probability, with its parameters.
const MOST_HYPOTHESES = 10;

const hypothesesSection = ({explanation}) => {
  const part = section(
      'What is missing',
      'Effects that were fitted to the recordings beside the ship\'s uncertain parameters, by their probability. ' +
          'Held-out gain: how much better [nats] what was left out is predicted than by the simulator as it is.');
  const shown = explanation.hypotheses.slice(0, MOST_HYPOTHESES);
  bars(
      part, 'probability of what may be missing',
      shown.map((h) => ({
                  label: hypothesisName(h.name),
                  value: h.probability,
                  color: h.chosen ? COLOR.sway : COLOR.grey,
                  tip: `${short(h.probability)}: ${h.sentence}`,
                })),
      {axis: 'probability', min: 0, max: 1});
  const rows = shown.flatMap(rowsOfHypothesis);
  part.append(hypothesesTable(rows));
  priorBars(part, rows.filter(({h, p}) => p && isKnown(p.prior95?.[0]) && h.chosen));
};

// A row for each parameter; the first one of a hypothesis shows the hypothesis.
const rowsOfHypothesis = (h) => {
  const parameters = Object.entries(h.parameters);
  if (parameters.length === 0) return [{h, first: true}];
  return parameters.map(([name, p], i) => ({h, name, p, first: i === 0}));
};

const hypothesesTable = (rows) => {
  const once = (format) => ({h, first}) => (first ? format(h) : '');
  const ofParameter = (format) => ({p}) => (p ? format(p) : '');
  return table(
             [
               {name: 'Missing', of: once((h) => hypothesisName(h.name))},
               {name: 'Evidence [nats]', of: once((h) => short(h.log_evidence)), kind: 'number'},
               {
                 name: 'Held-out gain [nats]',
                 of: once((h) => withSd(h.heldout_gain_nats, h.heldout_gain_sd_nats)),
                 kind: 'number'
               },
               {name: 'Parameter', of: ({name}) => name || ''},
               {name: 'Estimate', of: ofParameter(estimate), kind: 'number'},
               {name: '95 %', of: ofParameter((p) => between(p.ci95)), kind: 'number'},
             ],
             rows)
      .node;
};

// Parameters against what was believed before.
const priorBars = (part, rows) => {
  if (rows.length === 0) return;
  const share = ({prior95: [low, high]}, x) => (x - low) / (high - low);
  bars(
      part, 'parameters against what was believed before',
      rows.map(({name, p}) => ({
                 label: name,
                 low: Math.max(-0.5, share(p, p.ci95[0])),
                 high: Math.min(1.5, share(p, p.ci95[1])),
                 value: share(p, p.estimate),
                 color: COLOR.sway,
                 tip: `${estimate(p)}, 95 % ${between(p.ci95)}; before ${betweenShort(p.prior95)}`,
               })),
      {axis: '95 % interval, within that of what was believed before (0 to 1)', markValues: [0, 1], min: 0, max: 1});
};
